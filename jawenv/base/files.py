"""Files from outside become validated models, or one line that says what is wrong; files of ours appear whole."""

from __future__ import annotations

import contextlib
import glob
import json
import numbers
import os
import re
import stat
import tomllib
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Protocol, Self, TypeAlias, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationError

from jawenv.base.errors import InputError, printable, reason_of, shown
from jawenv.base.reading import read_text

Source: TypeAlias = Mapping[str, Any] | str | os.PathLike[str]
"""A mapping of fields, or the path of a JSON, TOML or YAML file that holds one."""

Model = TypeVar("Model", bound=BaseModel)
Built = TypeVar("Built")


def _real_number(value: object) -> float:
    """A float from any real number (numpy scalars too), but not from a bool or a string."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise ValueError("must be a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("must be a finite number") from None


Number = Annotated[float, BeforeValidator(_real_number)]
"""A finite real number: int, float or numpy scalar."""


def _in_one_line(text: str) -> str:
    """A text whose line ends and tabs are blanks, and which holds nothing else that steers a terminal."""
    text = " ".join(text.split())
    if printable(text) != text:
        raise ValueError("must be text without control characters")
    return text


Text = Annotated[str, AfterValidator(_in_one_line)]
"""A text that can be shown: in one line, without control characters."""


class InputModel(BaseModel):
    """A frozen pydantic model of something from outside: no unknown keys, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, /, **data: Any) -> None:
        """Validate keyword arguments into the model."""
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise InputError(_one_line(error, type(self), type(self).__name__)) from None

    # Marked as pydantic marks its own, so that model_validate fills the fields itself and a fault inside a
    # nested model keeps the path to its field.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


def validate(model: type[Model], data: object, source: str) -> Model:
    """Turn a mapping into a model.

    Args:
        model: the pydantic model.
        data: what came from outside, a mapping of field names.
        source: what the message begins with, such as the file's name.
    """
    if not isinstance(data, Mapping):
        raise InputError(f"{source}: content is {_kind(data)}; allowed: a mapping of keys to values")
    try:
        return model.model_validate(dict(data))
    except ValidationError as error:
        raise InputError(_one_line(error, model, source)) from None


def read_model(path: str | os.PathLike[str], model: type[Model]) -> Model:
    """Read a JSON, TOML or YAML file into a model."""
    return validate(model, read_mapping(path), os.fspath(path))


def read_into(path: str | os.PathLike[str], build: Callable[[Mapping[str, Any]], Built]) -> Built:
    """Build something of the mapping in a JSON, TOML or YAML file."""
    data = read_mapping(path)
    try:
        return build(data)
    except InputError as error:
        raise InputError(f"{os.fspath(path)}: {error}") from None


class _Loadable(Protocol):
    """A class whose objects can be made of a mapping of their fields, or of a file that holds one."""

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """One made of a mapping of its fields."""
        ...

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """One made of a file."""
        ...


Kind = TypeVar("Kind", bound=_Loadable)


def instance_of(kind: type[Kind], source: object, name: str) -> Kind:
    """An object of a class, given as itself, as a mapping of its fields, or as the path of a file.

    Args:
        kind: the class.
        source: what came from outside.
        name: what the message calls it.
    """
    if isinstance(source, kind):
        return source
    if isinstance(source, Mapping):
        return kind.from_dict(source)
    if isinstance(source, str | os.PathLike):
        return kind.load(source)
    allowed = f"a {kind.__name__}, a mapping of its fields, or the path of a file with them"
    raise InputError(f"{name} is {shown(source)}; allowed: {allowed}")


def read_mapping(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a JSON, TOML or YAML file (by its suffix) whose top level is a mapping."""
    path = Path(path)
    parse = _PARSERS.get(path.suffix.lower())
    if parse is None:
        kind = f"unknown file type '{path.suffix}'" if path.suffix else "no file, as its name has no ending"
        raise InputError(f"{path}: {kind}; allowed: {', '.join(FILE_TYPES)}")
    damaged = f"{path}: damaged {path.suffix[1:].upper()}"
    try:
        text = read_text(path)
    except UnicodeDecodeError as error:
        raise InputError(f"{damaged}: {_flat(error)}") from None
    try:
        data = parse(text)
    except RecursionError:
        raise InputError(f"{damaged}: nested too deeply") from None
    except MemoryError:
        raise InputError(f"{damaged}: more than the memory holds") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except ValueError as error:
        raise InputError(f"{damaged}: {_flat(error)}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: content is {_kind(data)}; allowed: a mapping of keys to values")
    return data


_MOST_LINKS = 40


@contextlib.contextmanager
def atomic_write(path: str | os.PathLike[str], *, synced: bool = True) -> Iterator[Path]:
    """Write a file that appears whole or not at all, also when interrupted.

    Args:
        path: of the file.
        synced: whether its content is on the disk before it gets its name, and so whole after a loss of power, too.

    Yields:
        Where to write. At the end of the block this becomes the file, in place of an older one, whose permissions it
        gets; a link stays, and what it leads to is replaced. After an error nothing is left of it.
    """
    path = Path(path)
    target = Path(os.path.realpath(path))
    if _among_devices(path):  # /dev/stdout would be replaced for the whole machine
        raise InputError(f"{path}: lies among devices; allowed: a file")
    mode = target.stat().st_mode if target.exists() else None
    if mode is not None and not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: is a device, pipe or socket; allowed: a file")
    unfinished = target.with_name(f".{target.name}.{uuid.uuid4().hex}.unfinished")
    try:
        yield unfinished
        if synced:
            with unfinished.open("rb+") as file:
                os.fsync(file.fileno())
        if mode is not None:
            unfinished.chmod(stat.S_IMODE(mode))
        unfinished.replace(target)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {reason_of(error)}") from None
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink()


def _among_devices(path: Path) -> bool:
    """Whether a path, or a link that it leads along, is a name of the system for something open."""
    for _ in range(_MOST_LINKS):
        place = Path(os.path.realpath(path.parent)).parts[1:3]
        if place[:1] in (("dev",), ("proc",)) and place != ("dev", "shm"):
            return True
        if not path.is_symlink():
            return False
        path = path.parent / os.readlink(path)
    return True


def remove_unfinished(output: Path) -> None:
    """Remove what `atomic_write` could not, since its process was killed.

    Args:
        output: a file, or a folder whose files count and not those of folders in it. Nobody else may be writing there.
    """
    left = [*output.parent.glob(f".{glob.escape(output.name)}.*.unfinished"), *output.glob(".*.unfinished")]
    for path in left:
        with contextlib.suppress(OSError):
            path.unlink()


def check_kept(output: Path, inputs: Iterable[object]) -> None:
    """Check that an output is no input, also by way of links; inputs that are no paths are passed over."""
    for source in (Path(each) for each in inputs if isinstance(each, str | os.PathLike)):
        if output.exists() and source.exists() and output.samefile(source):
            raise InputError(f"{output}: is read as {source}; allowed: an output that is no input")


def write_text(path: Path, text: str) -> None:
    """Write a text, wholly or not at all."""
    with atomic_write(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def write_json(path: str | os.PathLike[str], model: BaseModel) -> None:
    """Write a model as JSON, wholly or not at all."""
    path = Path(path)
    if path.suffix.lower() != ".json":
        raise InputError(f"file is {path}, and written as JSON; allowed: a name that ends in .json")
    write_text(path, model.model_dump_json(indent=2) + "\n")


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """JSON lets a later key silently replace an earlier one; here that is a fault."""
    mapping: dict[str, Any] = {}
    for key, value in pairs:
        if key in mapping:
            raise ValueError(f"key {shown(key)} appears twice")
        mapping[key] = value
    return mapping


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_unique_keys)


# A key of n parts costs tomllib n squared.
_LONG_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){30}""")


def _parse_toml(text: str) -> Any:
    if _LONG_KEY.search(text):
        raise ValueError("a key of more than 30 parts")
    return tomllib.loads(text)


def _parse_yaml(text: str) -> Any:
    try:
        from jawenv.base import plain_yaml
    except ImportError:
        raise InputError("YAML files need the package pyyaml; JSON and TOML files do not") from None
    return plain_yaml.parse(text)


_PARSERS: dict[str, Callable[[str], Any]] = {
    ".json": _parse_json,
    ".toml": _parse_toml,
    ".yaml": _parse_yaml,
    ".yml": _parse_yaml,
}
FILE_TYPES = tuple(_PARSERS)
"""Endings of the files that can be read."""


def _one_line(error: ValidationError, model: type[BaseModel], source: str) -> str:
    """The first problem of a ValidationError, and how many more there are."""
    problems = error.errors(include_url=False)
    # A misspelt key shows up as a missing one too; naming the unknown one helps more.
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{source}: {_problem(problems[0], model)}{more}"


def _problem(problem: Any, model: type[BaseModel]) -> str:
    field = ".".join(_brief(part) for part in problem["loc"])
    kind = problem["type"]
    message = _flat(problem["msg"]).removeprefix("Value error, ").replace("a valid dictionary", "a mapping")
    message = re.sub(r"^\w+ should ", "must ", message)
    if kind == "missing":
        return f"{field} is missing"
    if kind == "extra_forbidden":
        allowed = _allowed_keys(model, problem["loc"][:-1])
        return f"unknown key '{field}'" + (f"; allowed: {', '.join(allowed)}" if allowed else "")
    if kind == "value_error" and isinstance(problem["input"], Mapping | BaseModel):
        return f"{field}: {message}" if field else message
    value = shown(problem["input"])
    allowed_values, limits = re.subn(r"^must (be|have) ", "", message)
    return f"{field} is {value}; allowed: {allowed_values}" if limits else f"{field} = {value} {message}"


def _brief(part: int | str) -> str:
    """A key as messages name it, in 60 characters at most."""
    return shown(part).strip("'\"")


def _allowed_keys(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """The field names of the model that lies at a location, none when there is no one answer."""
    for part in location:
        if isinstance(part, int):
            continue
        if part not in model.model_fields:
            return []
        nested = _models_in(model.model_fields[part].annotation)
        if len(nested) != 1:
            return []
        model = nested[0]
    return list(model.model_fields)


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models_in(argument)]


def _kind(value: object) -> str:
    names = {type(None): "nothing", list: "a list", str: "text", int: "a number", float: "a number"}
    return names.get(type(value), f"a {type(value).__name__}")


def _flat(text: object) -> str:
    return " ".join(str(text).split())

"""A policy as an ONNX file, with the maneuver that it corrects: observation and step in, the environment's action out.

The file's metadata are its contract: ``environment`` (arguments of `gymnasium.make`), ``observation`` (where each part
lies), ``step``, ``action``, ``decision_hz``, ``weights_sha256`` and ``jawenv_version``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jawenv
from agents.policies import load_policy
from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.base.files import atomic_write
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.playing.policies.card import ModelCard, policy_folder
from jawenv.playing.policies.plain import PlainPolicy
from jawenv.playing.policies.residual import STEPS_SEEN, BaseTargets, ResidualPolicy

OPSET = 17
ACTIVATIONS = {"tanh": "Tanh", "relu": "Relu", "elu": "Elu"}
STEP = "decisions since the episode began; 0 at the first observation"
ACTION = (
    f"targets control, in [-1, 1]: {', '.join(CHANNELS)} as fractions of the patient's comfort (docs/environment.md)"
)


class Graph:
    """Nodes and constants of an ONNX graph, in the order of computation."""

    def __init__(self) -> None:
        with needs("ONNX", "onnx", group="train"):
            from onnx import helper, numpy_helper
        self._make, self._tensor = helper.make_node, numpy_helper.from_array
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, values: Any, dtype: type = np.float64) -> str:
        """The name of a constant."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(self._tensor(np.asarray(values, dtype=dtype), name))
        return name

    def node(self, kind: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        """The name of a node's output."""
        name = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(self._make(kind, list(inputs), [name], **attributes))
        return name

    def clipped(self, value: str, low: Any, high: Any) -> str:
        """``value`` between bounds that may differ by column."""
        return self.node("Min", self.node("Max", value, self.constant(low)), self.constant(high))


def write_onnx(policy: Path, output: Path) -> None:
    """Write a policy that corrects a maneuver as ONNX. It computes in double precision, as `PlainPolicy` does.

    Args:
        policy: a shipped policy's name, or a folder with card and weights.
        output: the file.

    Raises:
        InputError: no such policy, one without a maneuver, or a file that cannot be written.
        MissingPackageError: onnx is not installed.
    """
    if output.suffix != ".onnx":
        raise InputError(f"--output is {output}; allowed: a folder, or a file that ends in .onnx")
    folder = policy_folder(policy)
    if folder is None:
        raise InputError(
            f"policy is {str(policy)!r}; allowed: a shipped policy's name, or a folder with card and weights"
        )
    agent = load_policy(folder)
    if not isinstance(agent, ResidualPolicy) or type(agent.agent) is not PlainPolicy:
        raise InputError(f"{folder}: corrects no maneuver; allowed: a multilayer perceptron on a maneuver")
    card, graph = agent.agent.card, Graph()
    targets = _targets(agent.base, card)
    step = graph.node(
        "Min",
        graph.node("Max", "step", graph.constant(0, np.int64)),
        graph.constant(targets.shape[0] - STEPS_SEEN, np.int64),
    )
    table = graph.constant(targets)
    ahead = [
        graph.node("Gather", table, graph.node("Add", step, graph.constant(k, np.int64))) for k in range(STEPS_SEEN)
    ]
    seen = [graph.node("Cast", feature, to=_single()) for feature in ahead]
    value = graph.node("Concat", "observation", *seen, axis=1)
    value = _perceptron(graph, graph.node("Cast", value, to=_double()), agent.agent)
    corrected = graph.node("Add", ahead[0], graph.node("Mul", value, graph.constant(agent.base.scale)))
    _action(graph, graph.clipped(corrected, LOWEST, np.full(len(LOWEST), HIGHEST)))
    model = _model(graph, agent.parts.size, _contract(agent, card))
    with atomic_write(output) as unfinished:
        unfinished.write_bytes(model.SerializeToString())


def _targets(base: BaseTargets, card: ModelCard) -> NDArray[np.float64]:
    """(T, 4) targets of the maneuver at the end of each decision of an episode and of the last ones' look ahead."""
    steps = round(card.environment.episode_s * base.decision_hz) + STEPS_SEEN
    return base.maneuver.targets(np.arange(1, steps + 1) / base.decision_hz).value


def _perceptron(graph: Graph, value: str, policy: PlainPolicy) -> str:
    """The policy's own output, in [-1, 1] and of single precision as it decides."""
    architecture = policy.card.architecture
    last = len(architecture.layers) - 2
    for i in range(last + 1):
        weight, bias = (graph.constant(policy.weights[f"layers.{i}.{part}"]) for part in ("weight", "bias"))
        value = graph.node("Gemm", value, weight, bias, transB=1)
        if i < last:
            value = graph.node(ACTIVATIONS[architecture.activation], value)
    value = graph.node("Tanh", value) if architecture.squash == "tanh" else graph.clipped(value, -1.0, 1.0)
    return graph.node("Cast", graph.node("Cast", value, to=_single()), to=_double())


def _action(graph: Graph, targets: str) -> None:
    """The environment's action for targets: `jawenv.playing.maneuvers.maneuver.action_of`."""
    low = np.array(LOWEST)
    share = graph.node("Div", graph.node("Sub", targets, graph.constant(low)), graph.constant(0.5 * (HIGHEST - low)))
    action = graph.clipped(graph.node("Sub", share, graph.constant(1.0)), -1.0, 1.0)
    graph.node("Cast", action, to=_single(), output="action")


def _single() -> int:
    from onnx import TensorProto

    return int(TensorProto.FLOAT)


def _double() -> int:
    from onnx import TensorProto

    return int(TensorProto.DOUBLE)


def _contract(agent: ResidualPolicy, card: ModelCard) -> dict[str, str]:
    return {
        "environment": json.dumps({"id": card.environment.id, **card.environment.kwargs()}),
        "observation": json.dumps({name: [part.start, part.stop] for name, part in agent.parts.layout.items()}),
        "step": STEP,
        "action": ACTION,
        "decision_hz": f"{agent.decision_hz:g}",
        "weights_sha256": card.weights_sha256,
        "jawenv_version": jawenv.__version__,
    }


def _model(graph: Graph, size: int, contract: dict[str, str]) -> Any:
    from onnx import TensorProto, checker, helper

    inputs = [
        helper.make_tensor_value_info("observation", TensorProto.FLOAT, ["N", size]),
        helper.make_tensor_value_info("step", TensorProto.INT64, ["N"]),
    ]
    outputs = [helper.make_tensor_value_info("action", TensorProto.FLOAT, ["N", len(CHANNELS)])]
    made = helper.make_graph(graph.nodes, "policy", inputs, outputs, graph.constants)
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=8)
    helper.set_model_props(model, contract)
    checker.check_model(model)
    return model

"""Where the time of a control step goes: each part's time, its floating-point operations, its share of a core's peak.

The peak is that of fused multiply-adds on full vector registers, measured here. Operations of products of matrices
follow from their sizes (a multiply-add counts as two). Those of the scalar mechanics are counted by hand for one line
and one stage, to about a fifth; an exponential counts as the multiply-adds that it is made of, a root or a division as
one.
"""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium as gym
import numba
import numpy as np

import jawenv  # noqa: F401 - registers the environments
from jawenv.envs.world.plants import SUBSTEPS, true_motion
from jawenv.envs.world.record import N_NORMALS
from jawenv.filter.belief.state import tension_columns
from jawenv.filter.learn import conclude
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import ORDER, move
from jawenv.filter.model.regressors import middle_of, set_line_wrenches
from jawenv.filter.updates.measurement_update import update_motion
from jawenv.filter.updates.time_update import predict_by_tension, predict_cov
from jawenv.kernels.lanes import all_lines, total
from jawenv.kernels.noise import fill_normals
from jawenv.kernels.records import LINE, record_dtype, record_zeros
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.playing.rollout import DEFAULT_ENV

WORLDS, TICKS, SCRATCH_OFFSETS = 16, 5, (0, 16, 32, 48)
MUSCLES = LINES = 6
FUSED, VECTOR = 8, 8  # independent sums, numbers in a register
# Counted by hand: of one stage, without its lines; of each line; of a Jacobian beyond its stage; of a normal number.
PER_RATE, PER_LINE, PER_JACOBIAN, PER_NORMAL = 500, 75, 1300, 30


class Part(NamedTuple):
    """A part of the control step: its name, how often in a step, its kernel and its operations."""

    name: str
    times: int
    kernel: Callable[..., Any]
    operations: float


def product(rows: int, inner: int, columns: int) -> int:
    """Operations of a product of matrices."""
    return 2 * rows * inner * columns


def rate_operations() -> int:
    return PER_RATE + LINES * PER_LINE


def motion_operations() -> int:
    """Four stages twice, one Jacobian, and both series of the exponential."""
    series = (ORDER - 1) * product(N_STATES, N_STATES, N_STATES + N_WRENCH)
    return 8 * rate_operations() + PER_JACOBIAN + series


def time_update_operations() -> int:
    """A P, [A P, G W] [A, G]^T, [A, G] times the derivative by the tensions, and the lines' wrenches."""
    inputs = N_STATES + N_WRENCH
    products = product(N_STATES, N_STATES, N_STATES) + product(N_STATES, inputs, N_STATES)
    return products + product(N_STATES, inputs, tension_columns(MUSCLES)) + LINES * (PER_LINE + 5 * 30)


def update_operations() -> int:
    """H P, H P H^T, the factor, both whitenings, both corrections, the information."""
    m, n, columns = N_MEASUREMENTS, N_STATES, tension_columns(MUSCLES)
    rows = product(m, n, n) + product(m, n, m) // 2 + m**3 // 3 + product(m, n, columns)
    whitened = product(m, m, n + columns) // 2
    return rows + whitened + product(n, m, n + columns) + product(columns, m, columns)


def posterior_operations() -> int:
    """T^T Lambda T in two halves, the root and the factor of 3 m, three products of triangles, Y^T Y, the inverse."""
    columns, bends, parameters = 5 * MUSCLES, 3 * MUSCLES, 2 * MUSCLES
    bent = product(columns, columns, 3) + product(bends, 5, bends)
    triangles = 2 * bends**3 // 3 + 2 * product(bends, bends, bends) // 2
    reached = product(bends, bends, parameters + 1) // 2 + product(parameters, bends, parameters)
    return bent + triangles + reached + parameters**3 * 4 // 3 + 2 * columns * columns


@numba.njit
def true_part(device, model, world, settings, scratch):
    true_motion(device, world, scratch, settings)


@numba.njit
def motion_part(device, model, world, settings, scratch):
    move(model, world.known.belief.motion, scratch.samples, 0.01, False, scratch.filter.time.step)
    move(model, world.known.belief.predicted, scratch.samples, 0.01, True, scratch.filter.time.step)


@numba.njit
def time_part(device, model, world, settings, scratch):
    belief, time_scratch = world.known.belief, scratch.filter.time
    predict_cov(belief.motion_cov, settings.filter.wrench_variance, time_scratch)
    pose, position = middle_of(model, belief.motion, belief.predicted)
    set_line_wrenches(model, belief.basis, belief.trend, pose, position, time_scratch.line_wrench)
    predict_by_tension(belief.by_tension, time_scratch)


@numba.njit
def update_part(device, model, world, settings, scratch):
    known = settings.filter
    update_motion(model, world.known.belief, scratch.measured, known.used, 1.0, known, scratch.filter.update)


@numba.njit
def posterior_part(device, model, world, settings, scratch):
    conclude(world.known.belief, settings.filter, scratch.filter.belief)


@numba.njit
def noise_part(device, model, world, settings, scratch):
    fill_normals((world.truth.key[0], world.truth.key[1]), world.known.tick, scratch.normals)


PARTS = (
    Part("true motion", TICKS, true_part, SUBSTEPS * 4 * rate_operations()),
    Part("filter's motion and its derivative", TICKS, motion_part, motion_operations()),
    Part("time update's products", TICKS, time_part, time_update_operations()),
    Part("measurement update", TICKS, update_part, update_operations()),
    Part("posterior", 1, posterior_part, posterior_operations()),
    Part("noise", TICKS, noise_part, N_NORMALS * PER_NORMAL),
)


def worlds_at_work() -> Any:
    """A vector environment whose filters know something, on the way of gentle sines."""
    vec: Any = gym.make_vec(DEFAULT_ENV, num_envs=WORLDS, control="force")
    vec.reset(seed=0)
    for step in range(30):
        vec.step(gentle(step))
    return vec


def gentle(step: int) -> np.ndarray:
    phase = 0.7 * np.arange(4 * WORLDS).reshape(WORLDS, 4)
    return (0.3 * np.sin(2.0 * np.pi * 0.3 * step / 20.0 + phase)).astype(np.float32)


def best_of(run: Callable[[], object], repeats: int) -> float:
    """Processor seconds of the fastest run: what else the machine does only adds to it."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        run()
        best = min(best, time.process_time() - start)
    return float(best)


@numba.njit
def fused_multiply_adds(record, count):
    lines = all_lines(record.a)
    x, y = record.a[lines], record.b[lines]
    s0, s1, s2, s3, s4, s5, s6, s7 = x, y, x + y, x - y, x + 1.0, y + 1.0, x + 2.0, y + 2.0
    for _ in range(count):
        s0, s1, s2, s3 = s0 * x + y, s1 * x + y, s2 * x + y, s3 * x + y
        s4, s5, s6, s7 = s4 * x + y, s5 * x + y, s6 * x + y, s7 * x + y
    return total(((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7)))


def peak(repeats: int) -> float:
    """Floating-point operations per second of one core: fused multiply-adds in registers."""
    record = record_zeros(1, record_dtype([("a", "f8", (VECTOR,)), ("b", "f8", (VECTOR,))]))[0]
    record["a"], record["b"] = 0.999, 0.001
    count = 2_000_000
    fused_multiply_adds(record, 10)
    return 2 * FUSED * VECTOR * count / best_of(lambda: fused_multiply_adds(record, count), repeats)


def seconds_of(part: Part, vec: Any, repeats: int, count: int = 3_000) -> float:
    """Processor seconds of one call, over worlds that differ."""
    kernel = part.kernel

    @numba.njit(error_model="numpy")
    def loop(device, models, worlds, settings, scratches, count):
        for call in range(count):
            i = call % worlds.shape[0]
            kernel(device[0], models[i], worlds[i], settings[0], scratches[0])

    simulation = vec.simulation

    def run() -> None:
        given = simulation.device, simulation.models, simulation.worlds.copy(), simulation.settings
        loop(*given, simulation.scratches, count)

    run()
    return best_of(run, repeats) / count


def parts_table(repeats: int) -> list[tuple[str, ...]]:
    """Rows (part, microseconds in a control step of one world, kiloflops, gigaflops per second, share of the peak)."""
    vec, threads = worlds_at_work(), numba.get_num_threads()
    numba.set_num_threads(1)
    top = peak(repeats)
    rows, known = [("part", "us per step", "kflop", "Gflop/s", "of the peak")], 0.0
    for part in PARTS:
        seconds = part.times * seconds_of(part, vec, repeats)
        operations = part.times * part.operations
        known += seconds
        rate = operations / seconds
        rows.append(
            (part.name, f"{1e6 * seconds:.2f}", f"{operations / 1e3:.1f}", f"{rate / 1e9:.1f}", f"{rate / top:.0%}")
        )
    actions, active = gentle(30).astype(np.float64), np.ones(WORLDS, dtype=np.bool_)
    kernel = best_of(lambda: repeat(lambda: vec.simulation.advance(actions, active), 10), repeats) / 10 / WORLDS
    whole = best_of(lambda: repeat(lambda: vec.step(gentle(30)), 10), repeats) / 10 / WORLDS
    numba.set_num_threads(threads)
    rows.append(("all else that is compiled", f"{1e6 * (kernel - known):.2f}", "", "", ""))
    rows.append((f"Python around {WORLDS} worlds", f"{1e6 * (whole - kernel):.2f}", "", "", ""))
    rows.append(("whole control step", f"{1e6 * whole:.2f}", "", "", ""))
    rows.append(("peak of one core", "", "", f"{top / 1e9:.1f}", "100%"))
    return rows


def repeat(call: Callable[[], object], times: int) -> None:
    for _ in range(times):
        call()


def scratch_seconds(repeats: int) -> list[float]:
    """Processor seconds of a control step of one world, with the scratch at each of ``SCRATCH_OFFSETS`` past a line."""
    vec, threads = worlds_at_work(), numba.get_num_threads()
    numba.set_num_threads(1)
    simulation, times = vec.simulation, np.full(len(SCRATCH_OFFSETS), np.inf)
    actions, active = gentle(30).astype(np.float64), np.ones(WORLDS, dtype=np.bool_)
    dtype, before = simulation.scratches.dtype, simulation.worlds.copy()
    room = np.zeros(dtype.itemsize + 2 * LINE, dtype=np.uint8)
    line = -room.ctypes.data % LINE
    for _ in range(repeats):
        for place, offset in enumerate(SCRATCH_OFFSETS):
            simulation.scratches = room[line + offset :][: dtype.itemsize].view(dtype)
            simulation.worlds[:] = before
            spent = best_of(lambda: repeat(lambda: simulation.advance(actions, active), 10), 1)
            times[place] = min(times[place], spent / 10 / WORLDS)
    numba.set_num_threads(threads)
    return [float(seconds) for seconds in times]

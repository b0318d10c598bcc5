"""Run the filter in a device's loop: readings come over UDP from another process, 100 times a second.

    python examples/device_loop.py --seconds 60

The other process stands for the device: it sends the readings of a simulated patient on its own clock, and notes when
the belief about each comes back. A deadline is missed where that is later than the next reading. Few updates filter
earlier readings again and take longer; readings wait meanwhile in the socket. The filter's end is told the device's
address and connects to it, so that the system drops what others send.
"""

import argparse
import dataclasses
import multiprocessing
import select
import socket
import sys
import time
from multiprocessing.connection import Connection

import numpy as np

import jawenv
from jawenv.playing.maneuvers import Player
from jawenv.recordings.online import OnlineBelief

MANEUVER = "opening_with_swings_and_fore_aft"
READING = np.dtype([("tick", np.int64), ("measured", np.float64, 12), ("samples", np.float64, (3, 6))])
REPLY = np.dtype([("tick", np.int64), ("worst_sd", np.float64), ("misfit", np.float64)])
END = -1  # the tick of the last packet, which has no reading
PATIENCE_S = 60.0  # without a packet
LOST = 100  # ticks that may be missing before a packet
LOST_AND_CONFIRMED = 6000  # the same, where the packet after it goes on from there
SILENT_S = 1.0  # without a next reading, after which a device whose address nobody said may be another


def device(port: int, address: Connection, readings: np.ndarray, period_s: float) -> None:
    """Say the own address, send every reading at its time, and print how long the beliefs took to come back."""
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.connect(("127.0.0.1", port))
    address.send(link.getsockname())
    latency_s = np.full(len(readings), np.inf)
    sent_s = np.zeros(len(readings))
    begun = time.perf_counter() + period_s
    for i, reading in enumerate(readings):
        listen(link, begun + i * period_s, sent_s, latency_s)
        sent_s[i] = time.perf_counter()
        link.send(reading.tobytes())
    listen(link, time.perf_counter() + 1.0, sent_s, latency_s)
    ending = np.zeros((), READING)
    ending["tick"] = END
    link.send(ending.tobytes())
    arrived = latency_s[np.isfinite(latency_s)]
    p50, p99 = 1e3 * np.quantile(arrived, [0.5, 0.99]) if len(arrived) else (np.nan, np.nan)
    print(f"{len(readings)} readings, {len(readings) - len(arrived)} without a reply")
    print(f"latency: p50 {p50:.2f} ms, p99 {p99:.2f} ms")
    print(f"deadlines of {1e3 * period_s:g} ms missed: {np.sum(latency_s > period_s)}", flush=True)


def listen(link: socket.socket, until_s: float, sent_s: np.ndarray, latency_s: np.ndarray) -> None:
    """Take replies until the clock shows ``until_s``."""
    while (left := until_s - time.perf_counter()) > 0.0:
        if select.select([link], [], [], left)[0]:
            tick = int(np.frombuffer(link.recv(REPLY.itemsize), REPLY)[0]["tick"])
            latency_s[tick] = time.perf_counter() - sent_s[tick]


@dataclasses.dataclass
class Order:
    """Decides which packets are the device's next reading; a network loses, repeats, delays and damages packets."""

    device: object = None  # its address; None: nobody said it, and whoever speaks first is taken for it
    sender: object = None  # address of the latest reading
    heard_s: float = -np.inf  # by this computer's clock, when it came
    expected: int = 0  # tick of the next reading
    ahead: int = -1  # tick of the packet before, if it came from too far ahead
    dropped: int = 0  # packets

    def reading(self, packet: bytes, sender: object) -> np.void | None:
        """Return the reading or END, or count a packet that is neither."""
        silent = time.monotonic() - self.heard_s > SILENT_S
        owner = self.device or (None if silent else self.sender)
        if len(packet) == READING.itemsize and owner in (None, sender):
            reading = np.frombuffer(packet, READING)[0]
            if reading["tick"] == END and self.sender == sender:
                return reading
            if self._follows(int(reading["tick"])):
                self.sender, self.heard_s, self.ahead = sender, time.monotonic(), -1
                return reading
        self.dropped += 1
        return None

    def _follows(self, tick: int) -> bool:
        """A jump of more than a second needs a second packet that agrees: one flipped bit is no outage."""
        lost, since_ahead = tick - self.expected, tick - self.ahead
        if self.expected and LOST < lost <= LOST_AND_CONFIRMED and not 0 < since_ahead <= LOST:
            self.ahead = tick
            return False
        return 0 <= lost <= (LOST_AND_CONFIRMED if self.expected else LOST)


def serve(link: socket.socket, online: jawenv.OnlineFilter, device: object = None) -> OnlineBelief | None:
    """Answer every reading of the device, at its address, with the belief after it; a lost packet is an empty tick.

    The clock is the device's: a belief's time is its packet's tick. What is no next reading is dropped and counted.
    """
    order, belief = Order(device), None
    while True:
        try:
            reading = order.reading(*link.recvfrom(READING.itemsize + 1))
        except TimeoutError:
            print(f"no packet for {PATIENCE_S:g} s", file=sys.stderr)
            break
        if reading is None:
            continue
        if reading["tick"] == END:
            break
        for _ in range(order.expected, reading["tick"]):
            online.update(np.full(12, np.nan), np.full((3, 6), np.nan))
        belief = online.update(reading["measured"], reading["samples"])
        order.expected = int(reading["tick"]) + 1
        reply = np.array((reading["tick"], belief.log_sd.max(), belief.misfit), REPLY).tobytes()
        link.sendto(reply, order.sender) if device is None else link.send(reply)
    if order.dropped:
        print(f"{order.dropped} packets were no next reading of the device: dropped")
    return belief


def main() -> None:
    """Simulate what the device reads, and let it run against the filter."""
    parser = argparse.ArgumentParser(description="Run the filter in a device's loop over UDP.")
    parser.add_argument("--seconds", type=float, default=10.0, help="of readings")
    seconds = parser.parse_args().seconds
    if not 1.0 <= seconds <= 600.0:
        raise jawenv.InputError(f"seconds is {seconds:g}; allowed: 1 to 600")
    player = Player(MANEUVER)
    record = jawenv.play(player, patients=1, seed=0, env_kwargs={"record": True, "episode_s": seconds}).records[0]
    readings = np.zeros(len(record.measured), READING)
    readings["tick"], readings["measured"] = np.arange(len(readings)), record.measured
    readings["samples"][1:] = record.samples
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.bind(("127.0.0.1", 0))
        link.settimeout(PATIENCE_S)
        online = jawenv.OnlineFilter.of_record(record)
        spawn = multiprocessing.get_context("spawn")
        said, saying = spawn.Pipe(duplex=False)
        arguments = (link.getsockname()[1], saying, readings, record.dt)
        process = spawn.Process(target=device, args=arguments, daemon=True)
        process.start()
        address = said.recv()
        link.connect(address)
        belief = serve(link, online, address)
        process.join()
    if belief is not None:
        print(f"all within {belief.log_sd.max():.1%} after {belief.time_s:g} s, misfit {belief.misfit:.2f}")


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)

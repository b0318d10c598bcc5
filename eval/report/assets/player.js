"use strict";
// Plays the motions of two entries in step: the jaw from two sides, and over time commands, motion and sds.
(() => {
  const { motions } = report.data.playback;
  const section = document.getElementById("player");
  const slider = document.getElementById("time-slider");
  const play = document.getElementById("play");
  const speed = document.getElementById("speed");
  const clock = document.getElementById("clock");
  const inks = ["#1f77c4", "#d55e00", "#009e73", "#b0528a"];
  const dashes = [[], [6, 3], [2, 3], [8, 3, 2, 3]];
  const stages = [...section.querySelectorAll(".stage")].map((box) => ({ box, select: box.querySelector("select") }));
  let [now, playing, last] = [0, false, 0];

  function strips(canvas, motion) {
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const { frames } = motion;
    const worst = frames.sd.map((row) => Math.max(...row));
    const rows = [
      { title: "commands, −1 to 1", lines: motion.commands.map((name, c) => ({ name, values: frames.command.map((row) => row[c]), hold: true })), low: -1, high: 1 },
      { title: "motion, mm", lines: ["opening", "side", "fore-aft"].map((name, c) => ({ name, values: frames.moved.map((row) => row[c]) })) },
      { title: "sd of the parameters, the worst bold", log: true, low: 0.003, high: 0.6, lines: [...motion.parameters.map((_, c) => ({ name: "", values: frames.sd.map((row) => row[c]), thin: true })), { name: "worst", values: worst }] },
    ];
    const [left, right, each] = [40, 62, height / 3];
    const across = (time) => left + ((width - left - right) * time) / report.data.playback.end_s;
    canvas.across = across;
    rows.forEach((row, k) => strip(context, row, frames.time_s, across, { top: k * each + 22, bottom: (k + 1) * each - 12, left, right: width - right }));
  }

  function strip(context, row, times, across, { top, bottom, left, right }) {
    const all = row.lines.flatMap((line) => line.values);
    const [low, high] = [row.low ?? 5 * Math.floor(Math.min(0, ...all) / 5), row.high ?? 5 * Math.ceil(Math.max(1, ...all) / 5)];
    const scale = (v) => (row.log ? Math.log(Math.max(v, low) / low) / Math.log(high / low) : (v - low) / (high - low));
    const y = (v) => bottom - scale(v) * (bottom - top);
    context.font = `11.5px ${jaw.css("--font")}`;
    context.textAlign = "left";
    context.fillStyle = jaw.css("--text");
    context.fillText(row.title, left, top - 7);
    context.textAlign = "right";
    const ticks = row.log ? [0.005, 0.02, 0.05, 0.2, 0.5] : [low, (low + high) / 2, high];
    for (const tick of ticks) {
      context.fillStyle = jaw.css("--muted");
      context.fillText(row.log ? `${100 * tick} %` : tick.toFixed(high - low > 8 ? 0 : 1).replace("-", "−"), left - 5, y(tick) + 4);
      context.fillStyle = jaw.css("--line");
      context.fillRect(left, y(tick), right - left, 1);
    }
    const ends = [];
    row.lines.forEach((line, c) => {
      context.beginPath();
      line.values.forEach((v, i) => {
        if (i && line.hold) context.lineTo(across(times[i]), y(line.values[i - 1]));
        context[i ? "lineTo" : "moveTo"](across(times[i]), y(v));
      });
      context.strokeStyle = line.thin ? jaw.css("--muted") : row.log ? jaw.css("--text") : inks[c];
      context.lineWidth = line.thin ? 0.7 : 1.7;
      context.setLineDash(row.log ? [] : dashes[c]);
      context.stroke();
      if (line.name) ends.push({ name: line.name, at: y(line.values.at(-1)), ink: context.strokeStyle });
    });
    context.setLineDash([]);
    ends.sort((a, b) => a.at - b.at);
    ends.forEach((end, k) => { if (k) end.at = Math.max(end.at, ends[k - 1].at + 13); });
    const over = Math.max(0, ends.at(-1).at - bottom - 6);
    context.textAlign = "left";
    for (const end of ends) {
      context.fillStyle = jaw.css("--text");
      context.fillText(end.name, right + 6, end.at - over + 4);
    }
  }

  const readable = (parameter) => { const [kind, muscle] = parameter.split("/"); return `${kind === "log_b" ? "b" : "F_o"} of ${muscle.replaceAll("_", " ")}`; };

  function describe(motion, frame) {
    const worst = Math.max(...frame.sd);
    const ended = now > motion.frames.time_s.at(-1) + 0.5 ? "The episode has ended. " : "";
    const [opening, side, fore] = frame.moved.map((x) => (Math.abs(x) < 0.05 ? 0 : x).toFixed(1).replace("-", "−"));
    return `${ended}Opening ${opening} mm, side ${side} mm, fore-aft ${fore} mm; force ${Math.hypot(...frame.force).toFixed(1)} N. Known least: ${readable(motion.parameters[frame.sd.indexOf(worst)])}, ${(100 * worst).toFixed(1)} %.`;
  }

  function draw() {
    for (const { box, select } of stages) {
      const motion = motions[select.value];
      const frame = jaw.frameAt(motion, now);
      for (const canvas of box.querySelectorAll(".views canvas")) jaw.draw(canvas, canvas.dataset.view, motion, frame);
      box.querySelector(".cursor").style.left = `${box.querySelector(".strips").across(now)}px`;
      box.querySelector(".now").textContent = describe(motion, frame);
    }
    slider.value = now;
    const said = `${now.toFixed(1)} s of ${report.data.playback.end_s} s`;
    clock.textContent = said;
    slider.setAttribute("aria-valuetext", said);
  }

  // All anew: after another choice, another size or other colours.
  function drawAll() {
    for (const { box, select } of stages) strips(box.querySelector(".strips"), motions[select.value]);
    draw();
  }

  function step(at) {
    if (!playing) return;
    if (at - last > 36) {
      now += (Math.min(at - last, 250) / 1000) * Number(speed.value);
      last = at;
      if (now >= report.data.playback.end_s) { now = report.data.playback.end_s; set(false); }
      draw();
    }
    requestAnimationFrame(step);
  }

  function set(on) {
    playing = on;
    play.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (now >= report.data.playback.end_s) now = 0;
    last = performance.now();
    requestAnimationFrame(step);
  }

  function go(to) {
    now = Math.min(Math.max(to, 0), report.data.playback.end_s);
    draw();
  }

  play.addEventListener("click", () => set(!playing));
  slider.addEventListener("input", () => { set(false); go(Number(slider.value)); });
  section.addEventListener("keydown", (event) => {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
    if (event.key === " ") { event.preventDefault(); set(!playing); }
    if (event.key === "ArrowRight") go(now + 0.2);
    if (event.key === "ArrowLeft") go(now - 0.2);
  });
  for (const { select } of stages) select.addEventListener("change", drawAll);
  new ResizeObserver(drawAll).observe(section);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  drawAll();
})();

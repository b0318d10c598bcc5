"use strict";
// Films beside each other, in step, once through; still until asked where a reader wants no motion.
for (const section of document.querySelectorAll(".films")) {
  const SPEED = 2;
  const KNOWN = 0.05;
  const START_S = 3; // shown until the film plays: by then a jaw is open
  const { motions, end_s: end } = report.data.playback;
  const play = section.querySelector(".films-play");
  const clock = section.querySelector(".films-clock");
  const films = [...section.querySelectorAll("figure")].map((box) => ({ box, motion: motions[box.dataset.entry] }));
  let [now, playing, last] = [Math.min(START_S, end), false, 0];
  let begun = matchMedia("(prefers-reduced-motion: reduce)").matches;

  function draw() {
    for (const { box, motion } of films) {
      const frame = jaw.frameAt(motion, now);
      for (const canvas of box.querySelectorAll("canvas")) jaw.draw(canvas, canvas.dataset.view, motion, frame);
      const known = frame.sd.filter((sd) => sd <= KNOWN).length;
      box.querySelector(".now").textContent = `${known} of ${frame.sd.length} parameters known to ${100 * KNOWN}\u00a0%, the worst to ${(100 * Math.max(...frame.sd)).toFixed(1)}\u00a0%`;
    }
    clock.textContent = `${now.toFixed(1)} s of ${end} s`;
  }

  function step(at) {
    if (!playing) return;
    if (at - last > 36) {
      now = Math.min(now + (Math.min(at - last, 250) / 1000) * SPEED, end);
      last = at;
      if (now >= end) set(false);
      draw();
    }
    requestAnimationFrame(step);
  }

  function set(on) {
    playing = on;
    play.textContent = on ? "Pause" : "Play";
    if (!on) return;
    begun = true;
    if (now >= end) now = 0;
    last = performance.now();
    requestAnimationFrame(step);
  }

  play.addEventListener("click", () => set(!playing));
  new ResizeObserver(draw).observe(section);
  // Begins when it first comes into view, and pauses when it leaves it.
  new IntersectionObserver(([seen]) => {
    if (!seen.isIntersecting) set(false);
    else if (!begun) { now = 0; set(true); }
  }).observe(section);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
}

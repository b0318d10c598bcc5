// Films without a sound play while they are in view, unless the reader wants things to stay still.
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) {
  const watch = new IntersectionObserver(
    (seen) => seen.forEach(({ target, isIntersecting }) => (isIntersecting ? target.play().catch(() => {}) : target.pause())),
    { threshold: 0.6 },
  );
  addEventListener("DOMContentLoaded", () => document.querySelectorAll("video[loop][muted]").forEach((film) => watch.observe(film)));
}

// Films without a sound play while they are in view, unless the reader wants things to stay still.
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) {
  const watch = new IntersectionObserver(
    (seen) => seen.forEach(({ target, isIntersecting }) => (isIntersecting ? target.play().catch(() => {}) : target.pause())),
    { threshold: 0.6 },
  );
  addEventListener("DOMContentLoaded", () => document.querySelectorAll("video[loop][muted]").forEach((film) => watch.observe(film)));
}

// The theme's search box says what it is, and long names may break after an underscore.
addEventListener("DOMContentLoaded", () => {
  document.querySelector('[data-md-component="search"]')?.setAttribute("aria-label", "Search");
  for (const code of document.querySelectorAll(".md-typeset td code"))
    if (!code.childElementCount && code.textContent.length > 20) code.innerHTML = code.innerHTML.replaceAll("_", "_<wbr>");
});

// Each code block's buttons are a landmark of their own.
addEventListener("load", () => {
  document.querySelectorAll(".md-code__nav").forEach((nav, i) => nav.setAttribute("aria-label", `Code block ${i + 1}`));
});

// Who has no pointer scrolls what is too wide with the arrow keys.
addEventListener("load", () => {
  for (const box of document.querySelectorAll('.md-typeset__scrollwrap, .notebook-output, .md-typeset math[display="block"], .md-typeset p:has(> img)'))
    if (box.scrollWidth > box.clientWidth) {
      box.setAttribute("tabindex", "0");
      box.setAttribute("aria-label", "wider than the page: scrolls sideways");
      if (box.localName !== "math") box.setAttribute("role", "group");
    }
});

"use strict";
// Films of the first patient: those of a group play in step, from when they first come into view, and pause when they
// leave it; still until asked where a reader wants no motion.
(() => {
  const STILL_S = 2; // shown where nothing moves: by then a jaw is open
  const APART_S = 0.1;
  const { films } = report.data;
  const addresses = {};

  function address(entry) {
    const bytes = () => Uint8Array.from(atob(films[entry]), (letter) => letter.charCodeAt(0));
    return (addresses[entry] ??= URL.createObjectURL(new Blob([bytes()], { type: "video/mp4" })));
  }

  for (const group of document.querySelectorAll(".films")) {
    const shown = [...group.querySelectorAll("video")];
    const others = (film) => shown.filter((other) => other !== film);
    const play = (film) => film.play().catch(() => {});
    const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches;
    let begun = reduced;
    for (const film of shown) {
      if (film.dataset.entry) film.src = address(film.dataset.entry);
      const still = () => { if (begun === reduced) film.currentTime = STILL_S; }; // not played yet: no grey, on paper too
      film.addEventListener("loadeddata", still, { once: true });
      film.addEventListener("play", () => others(film).forEach(play));
      film.addEventListener("pause", () => { if (!film.ended) others(film).forEach((other) => other.pause()); });
      film.addEventListener("ratechange", () => others(film).forEach((other) => { other.playbackRate = film.playbackRate; }));
      const align = () => others(film).forEach((other) => { if (Math.abs(other.currentTime - film.currentTime) > APART_S) other.currentTime = film.currentTime; });
      film.addEventListener("seeked", align);
      if (film === shown[0]) film.addEventListener("timeupdate", align); // a busy machine starts them at different times
    }
    new IntersectionObserver(([seen]) => {
      if (!seen.isIntersecting) shown.forEach((film) => film.pause());
      else if (!begun) { begun = true; shown.forEach((film) => { film.currentTime = 0; play(film); }); }
    }).observe(group);
  }

  for (const stage of document.querySelectorAll(".stage")) {
    const [select, film] = ["select", "video"].map((part) => stage.querySelector(part));
    const choose = () => { film.src = address(select.value); };
    select.addEventListener("change", choose);
    choose();
  }
})();

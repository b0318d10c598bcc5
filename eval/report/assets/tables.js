"use strict";
// Tables that are sorted by a click on a heading, within what is ranked and within the rest, and filtered by a text.
// The first click on a heading puts the best first: the least, the most where data-best is "most", or what is nearest
// to data-best where that is a number. What has no value stays last.
(() => {
  const value = (row, column) => {
    const cell = row.cells[column];
    return cell.dataset.v === undefined ? cell.textContent.trim().toLowerCase() : Number(cell.dataset.v);
  };
  // How far a value is from the best of its column, on the scale of the column.
  const rank = (found, best) => (typeof found === "string" || !best ? found : best === "most" ? -found : Math.abs(found - Number(best)));

  function sort(table, heading, column) {
    const best = heading.dataset.best;
    const first = best === "most" ? "descending" : "ascending";
    const turned = heading.getAttribute("aria-sort") === first;
    for (const other of table.tHead.querySelectorAll("[aria-sort]")) other.setAttribute("aria-sort", "none");
    heading.setAttribute("aria-sort", turned === (first === "descending") ? "ascending" : "descending");
    for (const body of table.tBodies) {
      const rows = [...body.rows].sort((a, b) => {
        const [x, y] = [rank(value(a, column), best), rank(value(b, column), best)];
        if (Number.isNaN(x) || Number.isNaN(y)) return Number.isNaN(x) - Number.isNaN(y);
        return (x < y ? -1 : x > y ? 1 : 0) * (turned ? -1 : 1);
      });
      body.append(...rows);
    }
  }

  for (const table of document.querySelectorAll("table.sortable")) {
    const headings = [...table.tHead.rows[table.tHead.rows.length - 1].cells];
    headings.forEach((heading, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...heading.childNodes);
      heading.append(button);
      heading.setAttribute("aria-sort", "none");
      button.addEventListener("click", () => sort(table, heading, column));
    });
  }

  // What a cell says, in the unit of its heading, without interval and badge.
  const said = (cell) => {
    const copy = cell.cloneNode(true);
    for (const part of copy.querySelectorAll(".ci, .badge, br")) part.replaceWith(" ");
    return copy.textContent.trim().replace(/\s+/g, " ").replaceAll("−", "-");
  };

  function csv(table) {
    const [heads, above] = [...table.tHead.rows].reverse();
    const groups = above ? [...above.cells].flatMap((cell) => Array(cell.colSpan).fill(said(cell))) : [];
    const names = [...heads.cells].map((cell, i) => `${groups[i] || ""} ${said(cell)}`.trim());
    const rows = [...table.tBodies].flatMap((body) => [...body.rows].map((row) => [...row.cells].map(said)));
    return [names, ...rows].map((row) => row.map((text) => `"${text.replaceAll('"', '""')}"`).join(",")).join("\r\n") + "\r\n";
  }

  for (const box of document.querySelectorAll(".scroll:has(table.sortable)")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "csv";
    button.textContent = "Save as CSV";
    button.addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([csv(box.querySelector("table"))], { type: "text/csv" }));
      link.download = `${box.getAttribute("aria-label").replaceAll(" ", "_")}.csv`;
      link.click();
      URL.revokeObjectURL(link.href);
    });
    box.after(button);
  }

  const search = document.getElementById("filter");
  const count = document.getElementById("count");
  search?.addEventListener("input", () => {
    const wanted = search.value.trim().toLowerCase();
    const more = document.querySelector(".folded:has(#ranking-table) details");
    if (more && wanted) more.open = true;
    const rows = [...document.querySelectorAll("#ranking-table tbody tr")];
    for (const row of rows) row.hidden = !row.querySelector("td.text").textContent.toLowerCase().includes(wanted);
    const shown = rows.filter((row) => !row.hidden).length;
    count.textContent = `${shown} of ${rows.length} shown`;
  });

  for (const box of document.querySelectorAll(".scroll")) {
    const hint = document.createElement("p");
    hint.className = "hint";
    hint.textContent = "The table is wider than the page: scroll it sideways and down.";
    box.before(hint);
    const look = () => {
      const wide = box.querySelector("table").scrollWidth > box.clientWidth + 4;
      box.classList.toggle("wide", wide);
      hint.hidden = !wide;
      box.classList.toggle("more", wide && box.scrollLeft + box.clientWidth < box.scrollWidth - 4);
    };
    box.addEventListener("scroll", look, { passive: true });
    new ResizeObserver(look).observe(box);
    look();
  }
})();

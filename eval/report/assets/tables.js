"use strict";
// Tables that are sorted by a click on a heading, within what is ranked and within the rest, and filtered by a text.
(() => {
  const value = (row, column) => {
    const cell = row.cells[column];
    const number = Number(cell.dataset.v);
    return cell.dataset.v === undefined || Number.isNaN(number) ? cell.textContent.trim().toLowerCase() : number;
  };

  function sort(table, heading, column) {
    const up = heading.getAttribute("aria-sort") !== "ascending";
    for (const other of table.tHead.querySelectorAll("[aria-sort]")) other.setAttribute("aria-sort", "none");
    heading.setAttribute("aria-sort", up ? "ascending" : "descending");
    for (const body of table.tBodies) {
      const rows = [...body.rows].sort((a, b) => {
        const [x, y] = [value(a, column), value(b, column)];
        return (x < y ? -1 : x > y ? 1 : 0) * (up ? 1 : -1);
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

  const search = document.getElementById("filter");
  const count = document.getElementById("count");
  search?.addEventListener("input", () => {
    const wanted = search.value.trim().toLowerCase();
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

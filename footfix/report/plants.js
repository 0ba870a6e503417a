// The table of plants: sorts by any column; a click on a plant jumps to it and loops over it.

class PlantsTable {
  constructor(table, pick) {
    Object.assign(this, { table, pick, body: table.tBodies[0] });
    this.rows = [...this.body.rows];
    table.tHead.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) this.sort(button.closest("th"));
    });
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (row) this.choose(row);
    });
  }

  /** Sorts by a column; a second time the other way round. Numbers fall at first, words rise. */
  sort(header) {
    const column = header.cellIndex;
    const numeric = header.dataset.kind === "number";
    const old = header.getAttribute("aria-sort");
    const rising = old ? old === "descending" : !numeric;
    for (const other of this.table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    header.setAttribute("aria-sort", rising ? "ascending" : "descending");
    const value = (row) => {
      const text = row.cells[column].dataset.value ?? row.cells[column].textContent;
      return numeric ? Number.parseFloat(text) || 0 : text;
    };
    const order = (a, b) => (numeric ? value(a) - value(b) : value(a).localeCompare(value(b)));
    const sorted = [...this.body.rows].sort((a, b) => (rising ? order(a, b) : order(b, a)));
    this.body.append(...sorted);
  }

  choose(row) {
    for (const other of this.rows) other.classList.toggle("chosen", other === row);
    for (const other of this.rows) other.removeAttribute("aria-current");
    row.setAttribute("aria-current", "true");
    this.pick({ effector: row.dataset.effector, start: Number(row.dataset.start), end: Number(row.dataset.end) });
  }

  /** Chooses the next or the previous plant in the order that is shown. */
  walk(by) {
    const rows = [...this.body.rows];
    if (!rows.length) return;
    const chosen = rows.findIndex((row) => row.classList.contains("chosen"));
    const row = rows[chosen < 0 ? 0 : (chosen + by + rows.length) % rows.length];
    row.scrollIntoView({ block: "nearest" });
    this.choose(row);
  }

  clear() {
    for (const row of this.rows) {
      row.classList.remove("chosen");
      row.removeAttribute("aria-current");
    }
  }
}

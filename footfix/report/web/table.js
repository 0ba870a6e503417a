// A table that sorts by any column whose header holds a button.

class SortableTable {
  constructor(table) {
    Object.assign(this, { table, body: table.tBodies[0] });
    table.tHead.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) this.sort(button.closest("th"));
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
}

// The table of plants: a click on a plant jumps to it and loops over it.

class PlantsTable {
  constructor(table, pick) {
    Object.assign(this, { pick, body: table.tBodies[0] });
    this.rows = [...this.body.rows];
    this.sorting = new SortableTable(table);
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (row) this.choose(row);
    });
  }

  /** Shows which row is looked at. */
  mark(row) {
    this.clear();
    row.classList.add("chosen");
    row.setAttribute("aria-current", "true");
  }

  choose(row) {
    this.mark(row);
    this.pick(plantOf(row));
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

/** The plant that a row is about. */
function plantOf({ dataset }) {
  return { effector: dataset.effector, start: Number(dataset.start), end: Number(dataset.end) };
}

// The batch index: its table sorts, and shows the clips whose names hold what is typed.

const table = document.getElementById("clips");
new SortableTable(table);
document.documentElement.classList.add("live");
document.getElementById("filter").addEventListener("input", (event) => {
  const wanted = event.target.value.trim().toLowerCase();
  let shown = 0;
  for (const row of table.tBodies[0].rows) {
    row.hidden = !row.querySelector("th").textContent.toLowerCase().includes(wanted);
    shown += row.hidden ? 0 : 1;
  }
  document.getElementById("count").textContent = wanted ? `${shown} of ${table.tBodies[0].rows.length} clips` : "";
});

// Links to a frame: an address that ends in #f=123 opens the page there.

/** The frame that the page's address asks for, or null. */
function frameInAddress() {
  const found = /[#&]f=(\d+)/.exec(location.hash);
  return found ? Number(found[1]) : null;
}

/** Where the page opens: at the frame of its address, or else within the worst plant, or else where a foot first stands. */
function openPage(viewer) {
  const { player, contacts, table } = viewer;
  const asked = frameInAddress();
  const row = table.rows.find((each) => asked === null || (Number(each.dataset.start) <= asked && asked < Number(each.dataset.end)));
  if (row) {
    table.mark(row);
    viewer.choose(plantOf(row));
  }
  const first = Math.min(...contacts.lanes.flat().map((contact) => contact.start));
  const middle = row ? (plantOf(row).start + plantOf(row).end) / 2 : first;
  const frame = asked ?? middle;
  player.seek(Number.isFinite(frame) ? frame : 0);
  viewer.stage.view("three-quarter");
}

// Keys of the page.

const FIGURES = ["both", "after", "before", "beside"]; // in the order in which B shows them

function wireKeys(viewer) {
  document.addEventListener("keydown", (event) => {
    const { target } = event;
    if (event.defaultPrevented || event.altKey) return;
    if (target.closest("input:not([type=range]), select, textarea")) return;
    if (event.ctrlKey || event.metaKey) {
      if (event.key.toLowerCase() !== "z" || !viewer.timeline.editing) return;
      if (event.shiftKey) viewer.contacts.redo();
      else viewer.editor.undo();
    } else if (!(target === viewer.stage.canvas && viewer.orbit.key(event)) && !pageKey(viewer, event)) return;
    event.preventDefault();
    viewer.refresh();
  });
}

/** Does what a key asks for; false where it asks for nothing. */
function pageKey(viewer, event) {
  const { player, motion } = viewer;
  const onControl = event.target.closest("button, a, summary, input");
  const far = event.shiftKey ? 10 : 1;
  const keys = {
    " ": () => player.toggle(),
    ArrowLeft: () => player.stepBy(-far),
    ArrowRight: () => player.stepBy(far),
    Home: () => player.seek(0),
    End: () => player.seek(motion.frames),
    n: () => viewer.table.walk(1),
    p: () => viewer.table.walk(-1),
    l: () => viewer.toggleLoop(),
    e: () => viewer.toggleEditing(),
    f: () => viewer.toggle("follow"),
    b: () => viewer.showFigures(FIGURES[(FIGURES.indexOf(viewer.stage.figures) + 1) % FIGURES.length]),
    t: () => viewer.toggle("trails"),
    1: () => viewer.look("front"),
    2: () => viewer.look("side"),
    3: () => viewer.look("top"),
    4: () => viewer.look("three-quarter"),
    0: () => viewer.wholeFigure(),
    Escape: () => {
      player.loopOver(null);
      viewer.table.clear();
      viewer.wholeFigure();
    },
    Delete: () => {
      if (viewer.timeline.editing && viewer.contacts.selection) viewer.contacts.remove();
    },
  };
  // Space and arrows belong to the control that has the focus.
  if (onControl && [" ", "ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key)) return false;
  if (!(event.key in keys)) return false;
  keys[event.key]();
  return true;
}

// Pointers on the timeline (hover, jump, drag) and the form under it (edit, undo, download).

class TimelineInput {
  constructor(timeline) {
    Object.assign(this, { timeline, pointers: new Map(), drag: null });
    const { canvas } = timeline;
    const on = (type, handler, options) => canvas.addEventListener(type, handler.bind(this), options);
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.up);
    on("pointerleave", this.leave);
    on("wheel", this.wheel, { passive: false });
  }

  place(event) {
    const box = this.timeline.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    if (event.button !== 0) return;
    const { timeline } = this;
    const [x, y] = this.place(event);
    timeline.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, x);
    if (this.pointers.size === 2) {
      this.pinch = Math.abs(this.spread());
      this.drag = null;
      timeline.draft = null;
      return;
    }
    const hit = timeline.hit(x, y, event.pointerType === "touch");
    if (hit.kind === "end") {
      this.drag = { kind: "end", end: hit.end };
      timeline.contacts.select(hit.lane, hit.contact);
      timeline.draft = { lane: hit.lane, old: hit.contact, contact: hit.contact };
    } else if (hit.kind === "empty") {
      this.drag = { kind: "new", from: Math.round(timeline.frameAt(x)), lane: hit.lane };
    } else {
      if (hit.kind === "bar") timeline.contacts.select(hit.lane, hit.contact);
      this.drag = { kind: "scrub" };
      timeline.player.pause();
      timeline.player.seek(timeline.frameAt(x));
    }
  }

  spread() {
    const [a, b] = [...this.pointers.values()];
    return a - b;
  }

  move(event) {
    const { timeline, drag } = this;
    const [x, y] = this.place(event);
    const frame = timeline.frameAt(x);
    if (this.pointers.has(event.pointerId)) this.pointers.set(event.pointerId, x);
    if (this.pointers.size === 2) return this.pinchTo(Math.abs(this.spread()));
    if (!drag) return this.hoverAt(x, y, event.pointerType === "touch");
    timeline.hover = null;
    if (drag.kind === "scrub") timeline.player.seek(frame);
    else if (drag.kind === "end") this.dragEnd(drag.end, frame);
    else if (Math.abs(frame - drag.from) >= 1) this.dragNew(drag, frame);
    return undefined;
  }

  pinchTo(spread) {
    if (spread > 8) this.timeline.zoom(this.pinch / spread);
    this.pinch = Math.max(spread, 8);
    this.timeline.player.changed();
  }

  dragEnd(end, frame) {
    const { timeline } = this;
    const { old, lane } = timeline.draft;
    const [start, stop] = end === "start" ? [Math.min(frame, old.end - 1), old.end] : [old.start, Math.max(frame, old.start + 1)];
    timeline.draft.contact = timeline.contacts.resized(lane, old, start, stop);
    this.showDraft(end === "start" ? timeline.draft.contact.start : timeline.draft.contact.end);
  }

  dragNew(drag, frame) {
    const { timeline } = this;
    const seed = { start: drag.from, end: drag.from + 1, confidence: 1 };
    const contact = timeline.contacts.resized(drag.lane, seed, Math.min(drag.from, frame), Math.max(drag.from, frame));
    timeline.draft = { lane: drag.lane, old: null, contact };
    this.showDraft(frame);
  }

  showDraft(frame) {
    this.timeline.still.stale = true;
    this.timeline.player.seek(frame);
  }

  up(event) {
    const { timeline } = this;
    this.pointers.delete(event.pointerId);
    const { draft } = timeline;
    timeline.draft = null;
    this.drag = null;
    if (draft && draft.contact !== draft.old && event.type === "pointerup") {
      timeline.contacts.replace(draft.lane, draft.old, draft.contact);
    }
    timeline.still.stale = true;
    timeline.player.changed();
  }

  leave() {
    this.timeline.hover = null;
    this.timeline.player.changed();
  }

  hoverAt(x, y, finger) {
    const { timeline } = this;
    const inside = x >= timeline.gutter && x <= timeline.right;
    timeline.hover = inside ? { frame: timeline.frameAt(x), lane: timeline.laneAt(y) } : null;
    const { kind } = timeline.hit(x, y, finger);
    timeline.canvas.style.cursor = { end: "ew-resize", bar: "pointer", empty: "cell", none: "crosshair" }[kind];
    timeline.player.changed();
  }

  /** A sideways wheel moves along, a wheel with Ctrl zooms; a plain one scrolls the page as ever. */
  wheel(event) {
    const { timeline } = this;
    const [from, to] = timeline.window;
    if (event.ctrlKey || event.metaKey) {
      timeline.zoom(1.0015 ** event.deltaY, timeline.frameAt(this.place(event)[0]));
    } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      const delta = (event.shiftKey ? event.deltaY || event.deltaX : event.deltaX) / (timeline.right - timeline.gutter);
      timeline.zoomTo(from + delta * (to - from), to + delta * (to - from));
    } else return;
    event.preventDefault();
    timeline.player.changed();
  }
}

/** What the curves say at a frame, in words. */
function describe(timeline, frame, lane) {
  const { motion, contacts } = timeline;
  const index = Math.max(0, Math.min(motion.shown - 1, Math.round(frame / motion.step)));
  const at = index * motion.step;
  const head = `Frame ${at}, ${(at * motion.frameTime).toFixed(2)} s`;
  if (lane === null) return head;
  const lanes = motion.soles.length;
  const height = (when) => ((motion.points[when][(index * lanes + lane) * 3 + 1] - motion.floor) * 100).toFixed(1);
  const speed = (when) => (motion.speeds[when][index * lanes + lane] * 100).toFixed(0);
  const contact = contacts.at(lane, at);
  const planted = !contact ? "free" : wishOf(contact) === "forbid" ? "contact forbidden"
    : `planted ${contact.start}–${contact.end}, ${wishOf(contact) === "force" ? "forced" : `confidence ${(contact.confidence ?? 1).toFixed(2)}`}`;
  return `${head}: ${named(contacts.effectors[lane])} ${planted}. `
    + `Height ${height("before")} → ${height("after")} cm, speed ${speed("before")} → ${speed("after")} cm/s`;
}

/** A contacts file as text: a contact a line, since people edit it by hand. */
function spelled({ effectors, ...rest }) {
  const open = (object) => JSON.stringify(object).replace(/\}$/, Object.keys(object).length ? ", " : "");
  const block = (lines, indent) => (lines.length ? `[\n${lines.map((line) => indent + line).join(",\n")}\n${indent.slice(1)}]` : "[]");
  const lines = effectors.map(({ contacts, ...effector }) => (
    `${open(effector)}"contacts": ${block(contacts.map((contact) => JSON.stringify(contact)), "   ")}}`
  ));
  return `${open(rest)}"effectors": ${block(lines, " ")}}`;
}

/** The form that edits the contact that is selected, or adds one, and hands the file out. */
class Editor {
  constructor(root, timeline, say) {
    Object.assign(this, { root, timeline, say, contacts: timeline.contacts });
    this.saved = this.contacts.lanes;
    const part = (name) => root.querySelector(`[data-edit="${name}"]`);
    this.parts = Object.fromEntries(
      ["lane", "start", "end", "add", "delete", "force", "forbid", "undo", "redo", "previous", "next", "download", "state"]
        .map((name) => [name, part(name)]),
    );
    this.contacts.effectors.forEach((effector, lane) => {
      this.parts.lane.append(new Option(named(effector), String(lane)));
    });
    const act = (name, handler) => this.parts[name].addEventListener("click", handler);
    act("add", () => this.add());
    act("delete", () => this.act(() => this.contacts.remove(), "Contact deleted"));
    act("force", () => this.act(() => this.contacts.wish("force"), "Contact changed"));
    act("forbid", () => this.act(() => this.contacts.wish("forbid"), "Contact changed"));
    act("undo", () => this.undo());
    act("redo", () => this.act(() => this.contacts.redo(), "Redone"));
    act("previous", () => this.walk(-1));
    act("next", () => this.walk(1));
    act("download", () => this.download());
    this.parts.lane.addEventListener("change", () => this.contacts.select(0, null));
    for (const end of ["start", "end"]) {
      this.parts[end].addEventListener("change", () => this.retime());
    }
    this.contacts.listeners.add(() => this.refresh());
    this.refresh();
  }

  /** Whether there are contacts that were not handed out yet. */
  get unsaved() {
    return this.contacts.lanes !== this.saved;
  }

  get lane() {
    return Number(this.parts.lane.value);
  }

  act(step, words) {
    step();
    this.say(words);
  }

  undo() {
    this.act(() => this.contacts.undo(), "Undone");
  }

  /** Selects the contact before or after the one that is selected, or after the playhead. */
  walk(by) {
    const list = this.contacts.lanes[this.lane];
    const chosen = this.contacts.selection ? list.indexOf(this.contacts.selection.contact) : -1;
    const { frame } = this.timeline.player;
    const nearest = by > 0 ? list.findIndex((each) => each.end > frame) : list.findLastIndex((each) => each.start <= frame);
    const contact = list[chosen >= 0 ? chosen + by : nearest];
    if (!contact) return this.say("No further contact");
    this.contacts.select(this.lane, contact);
    this.timeline.player.pause();
    this.timeline.player.seek(contact.start);
    return this.say(`Contact from frame ${contact.start} to ${contact.end}`);
  }

  add() {
    const { player, motion } = this.timeline;
    const half = 0.1 / motion.frameTime;
    const added = this.contacts.add(this.lane, player.frame - half, player.frame + half);
    this.say(added ? "Contact added at the playhead" : "There is a contact at the playhead already");
  }

  retime() {
    if (!this.contacts.selection) return;
    const [start, end] = [this.parts.start.valueAsNumber, this.parts.end.valueAsNumber];
    if (Number.isFinite(start) && Number.isFinite(end)) this.contacts.resize(start, end);
    this.refresh();
  }

  refresh() {
    const { selection, done, undone } = this.contacts;
    const { parts } = this;
    for (const name of ["start", "end", "delete", "force", "forbid"]) parts[name].disabled = !selection;
    parts.undo.disabled = !done.length;
    parts.redo.disabled = !undone.length;
    if (selection) parts.lane.value = String(selection.lane);
    for (const end of ["start", "end"]) parts[end].value = selection ? String(selection.contact[end]) : "";
    for (const wish of ["force", "forbid"]) {
      parts[wish].setAttribute("aria-pressed", String(Boolean(selection && wishOf(selection.contact) === wish)));
    }
    parts.state.textContent = this.unsaved ? `${done.length} ${done.length === 1 ? "change" : "changes"}, not yet downloaded` : "";
    this.timeline.still.stale = true;
    this.timeline.player.changed();
  }

  download() {
    const text = `${spelled(this.contacts.toDocument())}\n`;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = this.root.dataset.file;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    this.saved = this.contacts.lanes;
    this.parts.state.textContent = `Downloaded ${this.root.dataset.file}`;
  }
}

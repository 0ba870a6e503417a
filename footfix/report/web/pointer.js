// Pointers on the timeline: hover tells values, a drag scrubs, and with editing on it moves the ends of contacts.

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
    timeline.hover = inside ? { frame: timeline.frameAt(x), lane: timeline.laneAt(y), knees: timeline.kneesAt(y) } : null;
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

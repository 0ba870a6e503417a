// The form under the timeline: edits contacts without a pointer, undoes, and hands the contacts file out.

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

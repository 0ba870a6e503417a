// The contacts as a person edits them: values in, values out, every step can be undone.
//
// A contact is {start, end, confidence?, position_m?, force?, forbid?} as in the contacts file. Contacts are
// never changed in place, so an earlier state is simply kept.

/** What a person wants of a contact: "force", "forbid" or nothing. */
function wishOf(contact) {
  return ["force", "forbid"].find((wish) => contact[wish] === true || contact.wish === wish);
}

class Contacts {
  constructor(document, frames, plants) {
    this.document = document;
    this.frames = frames;
    this.outcomes = new Map(plants.map(([name, start, before, after, outcome]) => [`${name} ${start}`, { before, after, outcome }]));
    this.lanes = (document.effectors || []).map((effector) => effector.contacts || []);
    this.untouched = new Set(this.lanes.flat());
    this.undone = [];
    this.done = [];
    this.selection = null; // {lane, contact}
    this.listeners = new Set();
  }

  get effectors() {
    return this.document.effectors || [];
  }

  changed() {
    for (const listener of this.listeners) listener();
  }

  select(lane, contact) {
    this.selection = contact ? { lane, contact } : null;
    this.changed();
  }

  /** Puts `contact` in the place of `old` (null: adds it, or, as the new one, removes it), as one step to undo. */
  replace(lane, old, contact) {
    this.done.push(this.lanes);
    this.undone = [];
    const rest = this.lanes[lane].filter((each) => each !== old);
    const contacts = contact ? [...rest, contact].sort((a, b) => a.start - b.start) : rest;
    this.lanes = this.lanes.map((each, k) => (k === lane ? contacts : each));
    this.select(lane, contact);
  }

  /** The frames that a contact may reach without touching its neighbours: [first start, last end]. */
  room(lane, contact) {
    let [low, high] = [0, this.frames];
    for (const other of this.lanes[lane]) {
      if (other === contact) continue;
      if (other.end <= contact.start) low = Math.max(low, other.end);
      else if (other.start >= contact.end) high = Math.min(high, other.start);
    }
    return [low, high];
  }

  /** The contact with other ends, kept within its room; what was measured on the old stretch goes. */
  resized(lane, contact, start, end) {
    const [low, high] = this.room(lane, contact);
    const first = Math.max(low, Math.min(Math.round(start), high - 1));
    const last = Math.max(first + 1, Math.min(Math.round(end), high));
    if (first === contact.start && last === contact.end) return contact;
    const { position_m: _, ...kept } = contact;
    return { ...kept, start: first, end: last, confidence: 1 };
  }

  resize(start, end) {
    const { lane, contact } = this.selection;
    const next = this.resized(lane, contact, start, end);
    if (next !== contact) this.replace(lane, contact, next);
  }

  /** Adds a contact over these frames, as far as there is room; false where there is none. */
  add(lane, start, end) {
    const middle = Math.max(0, Math.min(Math.floor((start + end) / 2), this.frames - 1));
    if (this.at(lane, middle)) return false;
    const seed = { start: middle, end: middle + 1, confidence: 1 };
    const [low, high] = this.room(lane, seed);
    this.replace(lane, null, {
      start: Math.max(low, Math.min(Math.round(start), middle)),
      end: Math.min(high, Math.max(Math.round(end), middle + 1)),
      confidence: 1,
    });
    return true;
  }

  remove() {
    const { lane, contact } = this.selection;
    this.replace(lane, contact, null);
  }

  /** Sets the wish "force" or "forbid", or takes it away where it is set already. */
  wish(wish) {
    const { lane, contact } = this.selection;
    const { wish: _, force: __, forbid: ___, ...rest } = contact;
    this.replace(lane, contact, wishOf(contact) === wish ? rest : { ...rest, [wish]: true });
  }

  undo() {
    if (!this.done.length) return;
    this.undone.push(this.lanes);
    this.lanes = this.done.pop();
    this.select(0, null);
  }

  redo() {
    if (!this.undone.length) return;
    this.done.push(this.lanes);
    this.lanes = this.undone.pop();
    this.select(0, null);
  }

  /** The contact of a lane at a frame, or undefined. */
  at(lane, frame) {
    return this.lanes[lane].find((contact) => contact.start <= frame && frame < contact.end);
  }

  /** What became of a contact: {before, after, outcome}, slides in millimetres; nothing for one that was edited. */
  outcome(lane, contact) {
    return this.untouched.has(contact) ? this.outcomes.get(`${this.effectors[lane].name} ${contact.start}`) : undefined;
  }

  /** Whether an effector is planted at a frame. */
  planted(lane, frame) {
    const contact = this.at(lane, frame);
    return contact !== undefined && wishOf(contact) !== "forbid";
  }

  /** The contacts file: the document it came from, with the contacts as they are now. */
  toDocument() {
    const effectors = this.effectors.map((effector, k) => ({ ...effector, contacts: this.lanes[k] }));
    return { ...this.document, effectors };
  }
}

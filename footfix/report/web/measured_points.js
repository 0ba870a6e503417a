// What the measures look at while a foot is planted: the toe joint, the ankle of a flat foot, or the sole point itself.

const FEWEST = 3; // frames that heel and toe must stand together for the ankle to be looked at
const TRIMMED = 5; // frames from which on the first and the last one, in which a foot still lands or leaves, do not count

/** The frames of a contact that are measured, [first, the one after the last]. */
function counted({ start, end }) {
  const trim = end - start >= TRIMMED ? 1 : 0;
  return [start + trim, end - trim];
}

class Seen {
  constructor(motion, contacts) {
    Object.assign(this, { motion, contacts });
    this.toeOf = new Map(feetOf(motion, contacts.effectors).map((foot) => [foot.heel, foot.toe]));
    this.ways = new Map(); // contact -> {before, after}, as they are found; a contact that changes may change others
    contacts.listeners.add(() => this.ways.clear());
  }

  /** The joint that is looked at in a contact (-1: the sole point), and the stretches of frames that count. */
  of(lane, contact) {
    const [first, last] = counted(contact);
    const joint = this.motion.seen[lane];
    if (joint < 0 || this.contacts.effectors[lane].part !== "heel") return { joint, spans: [[first, last]] };
    const toe = this.toeOf.get(lane);
    const spans = (toe === undefined ? [] : this.contacts.lanes[toe])
      .filter((other) => wishOf(other) !== "forbid")
      .map(counted)
      .map(([a, b]) => [Math.max(a, first), Math.min(b, last)])
      .filter(([a, b]) => b > a);
    const together = spans.reduce((sum, [a, b]) => sum + b - a, 0);
    return together >= FEWEST ? { joint, spans } : { joint: -1, spans: [[first, last]] };
  }

  /**
   * The way of what is looked at, "before" or "after", at the height that the sole has on average. On a belt it is the
   * way over the belt, drawn where the belt has come to at the shown frame `now`.
   */
  way(when, lane, contact, now = 0) {
    const known = this.ways.get(contact) || {};
    this.ways.set(contact, known);
    known[when] ||= this.wayOver(when, lane, contact);
    const { ground } = this.motion;
    return ground ? known[when].map(([x, y, z]) => [x + ground[now * 3], y, z + ground[now * 3 + 2]]) : known[when];
  }

  /** The same over a belt that is back where it began. */
  wayOver(when, lane, contact) {
    const { motion } = this;
    const { ground } = motion;
    const rolled = (i, k) => (ground ? -ground[i * 3 + k] : 0);
    const { joint, spans } = this.of(lane, contact);
    const indices = spans.flatMap(([a, b]) => {
      const from = Math.min(motion.shown - 1, Math.ceil(a / motion.step));
      const to = Math.max(from, Math.min(motion.shown - 1, Math.ceil(b / motion.step) - 1));
      return Array.from({ length: to - from + 1 }, (_, k) => from + k);
    });
    const sole = (i) => (i * motion.soles.length + lane) * 3;
    const height = indices.reduce((sum, i) => sum + motion.points[when][sole(i) + 1], 0) / indices.length;
    const [places, at] = joint < 0
      ? [motion.points[when], sole]
      : [motion.joints[when], (i) => (i * motion.parents.length + joint) * 3];
    return indices.map((i) => [places[at(i)] + rolled(i, 0), height, places[at(i) + 2] + rolled(i, 2)]);
  }
}

/** The place in the middle of a way: the median along each axis. */
function middlePlace(way) {
  const median = (k) => way.map((place) => place[k]).sort((a, b) => a - b)[way.length >> 1];
  return [median(0), median(1), median(2)];
}

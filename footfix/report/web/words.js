// What the page says in words.

const OUTCOMES = { kept: "left alone", partly: "held in part", released: "let go" };

/** The name of an effector as people read it. */
function named(effector) {
  return effector.name.replaceAll("_", " ");
}

/** What the curves say at a frame, in words. */
function describe(timeline, frame, lane, knees = null) {
  const { motion, contacts } = timeline;
  const index = Math.max(0, Math.min(motion.shown - 1, Math.round(frame / motion.step)));
  const at = index * motion.step;
  const head = `Frame ${at}, ${(at * motion.frameTime).toFixed(2)} s`;
  if (knees) return `${head}: ${kneesInWords(knees, index)}`;
  if (lane === null) return head;
  const lanes = motion.soles.length;
  const height = (when) => ((motion.points[when][(index * lanes + lane) * 3 + 1] - motion.floor) * 100).toFixed(1).replace("-0.0", "0.0");
  const speed = (when) => (motion.speeds[when][index * lanes + lane] * 100).toFixed(0);
  return `${head}: ${named(contacts.effectors[lane])} ${inWords(contacts, lane, at)}. `
    + `Height ${height("before")} → ${height("after")} cm, speed ${speed("before")} → ${speed("after")} cm/s`;
}

function inWords(contacts, lane, frame) {
  const contact = contacts.at(lane, frame);
  if (!contact) return "free";
  const wish = wishOf(contact);
  if (wish === "forbid") return "contact forbidden";
  const certain = wish === "force" ? "forced" : `confidence ${(contact.confidence ?? 1).toFixed(2)}`;
  const found = contacts.outcome(lane, contact);
  const slides = found ? `, ${OUTCOMES[found.outcome] || found.outcome}, slides ${found.before?.toFixed(0)} → ${found.after?.toFixed(0)} mm` : "";
  return `planted ${contact.start}–${contact.end}, ${certain}${slides}`;
}

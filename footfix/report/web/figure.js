// What the motion tells about the figure: its sides, its feet, where it faces and where its middle goes.

/** For each joint "left", "right" or "" by the leg it belongs to. */
function sidesOf({ parents, hips }) {
  const sides = parents.map(() => "");
  const own = new Map(hips);
  parents.forEach((parent, joint) => {
    sides[joint] = own.get(joint) || (parent >= 0 ? sides[parent] : "");
  });
  return sides;
}

/** Heel and toe of the same leg, with the joint that carries the heel. */
function feetOf(motion, effectors) {
  const leg = (effector) => effector.name.replace(/_(heel|toe)$/, "");
  const known = effectors.slice(0, motion.soles.length);
  return known.flatMap((effector, heel) => {
    if (effector.part !== "heel") return [];
    const toe = known.findIndex((other) => other.part === "toe" && leg(other) === leg(effector));
    return toe < 0 ? [] : [{ heel, toe, ankle: motion.soles[heel] }];
  });
}

/** Where the figure faces, as a turn about the vertical: across the hips, or along its way. */
function headingAt({ joints, parents, hips, root, shown }, index) {
  let [x, z] = [0, 0];
  const at = (i, joint) => (i * parents.length + joint) * 3;
  const [one, other] = ["left", "right"].map((side) => hips.find((hip) => hip[1] === side));
  if (one && other) {
    const [left, right] = [at(index, one[0]), at(index, other[0])];
    // forward = left x up
    x = -(joints.after[left + 2] - joints.after[right + 2]);
    z = joints.after[left] - joints.after[right];
  } else {
    const [from, to] = [at(Math.max(0, index - 15), root), at(Math.min(shown - 1, index + 15), root)];
    x = joints.after[to] - joints.after[from];
    z = joints.after[to + 2] - joints.after[from + 2];
  }
  return Math.atan2(x, z);
}

/** The way of the figure's middle, smoothed over a second, so that a camera that follows does not bob. */
function smoothPath({ joints, parents, drawn, shown, step, frameTime }) {
  const half = Math.round(0.5 / (frameTime * step));
  const path = new Float32Array(shown * 3);
  const sums = [0, 1, 2].map(() => new Float64Array(shown + 1));
  for (let i = 0; i < shown; i++) {
    const [low, high] = bounds(joints.after, i * parents.length, drawn);
    for (let k = 0; k < 3; k++) sums[k][i + 1] = sums[k][i] + (low[k] + high[k]) / 2;
  }
  for (let i = 0; i < shown; i++) {
    const reach = Math.min(half, i, shown - 1 - i);
    for (let k = 0; k < 3; k++) path[i * 3 + k] = (sums[k][i + reach + 1] - sums[k][i - reach]) / (2 * reach + 1);
  }
  return path;
}

// Rounds: a loop is played on and on. The figure stays in its first round; the floor goes back under it, round by round.

class Rounds {
  constructor(motion, player) {
    Object.assign(this, { motion, player, seen: 0, kept: null });
    const { round, root, joints } = motion;
    if (!round) return;
    const [x, z] = [joints.after[root * 3], joints.after[root * 3 + 2]];
    const [turnedX, turnedZ] = turnedBy(round.yaw, x, z);
    this.once = { yaw: round.yaw, x: x + round.travel[0] - turnedX, z: z + round.travel[1] - turnedZ };
  }

  /** What the rounds that have been played do to a place: a turn, then a shift. */
  get all() {
    const count = this.motion.round ? this.player.rounds : 0;
    if (this.kept?.count !== count) {
      let [yaw, x, z] = [0, 0, 0];
      for (let k = 0; k < count; k++) {
        [x, z] = turnedBy(this.once.yaw, x, z);
        [yaw, x, z] = [yaw + this.once.yaw, x + this.once.x, z + this.once.z];
      }
      this.kept = { count, yaw, x, z };
    }
    return this.kept;
  }

  /** Where a place of the first round lies on the floor in the present one. */
  out([x, y, z]) {
    const { yaw, x: alongX, z: alongZ } = this.all;
    const [turnedX, turnedZ] = turnedBy(yaw, x, z);
    return [turnedX + alongX, y, turnedZ + alongZ];
  }

  /** A place on the floor, as it is seen from the first round. */
  home([x, y, z]) {
    const { yaw, x: alongX, z: alongZ } = this.all;
    const [turnedX, turnedZ] = turnedBy(-yaw, x - alongX, z - alongZ);
    return [turnedX, y, turnedZ];
  }

  /** A place of the first round, so many rounds earlier or later. */
  moved([x, y, z], count) {
    for (let k = 0; k < Math.abs(count); k++) {
      if (count > 0) {
        [x, z] = turnedBy(this.once.yaw, x, z);
        [x, z] = [x + this.once.x, z + this.once.z];
      } else [x, z] = turnedBy(-this.once.yaw, x - this.once.x, z - this.once.z);
    }
    return [x, y, z];
  }

  /** A look from where one stands on the floor goes on over the seam. */
  turn(camera) {
    if (!this.motion.round || this.seen === this.player.rounds) return;
    const yaw = (this.player.rounds - this.seen) * this.once.yaw;
    this.seen = this.player.rounds;
    camera.yaw -= yaw;
    [camera.pan[0], camera.pan[2]] = turnedBy(-yaw, camera.pan[0], camera.pan[2]);
  }

  /** The smooth way of a figure through its round, without a beginning or an end. */
  path(open) {
    const { motion } = this;
    const length = roundLength(motion);
    const half = Math.min(Math.round(0.5 / (motion.frameTime * motion.step)), length);
    const path = new Float32Array(motion.shown * 3);
    for (let i = 0; i < motion.shown; i++) {
      const sum = [0, 0, 0];
      for (let j = i - half; j <= i + half; j++) {
        const count = Math.floor(j / length);
        const at = (j - count * length) * 3;
        this.moved([open[at], open[at + 1], open[at + 2]], count).forEach((value, k) => (sum[k] += value));
      }
      for (let k = 0; k < 3; k++) path[i * 3 + k] = sum[k] / (2 * half + 1);
    }
    return path;
  }
}

function turnedBy(yaw, x, z) {
  const [s, c] = [Math.sin(yaw), Math.cos(yaw)];
  return [c * x + s * z, c * z - s * x];
}

/** The shown frames of one round: the last frame of a closed one is the first of the next. */
function roundLength(motion) {
  return motion.shown - (motion.round.closed ? 1 : 0);
}

/** The way of the root, frame by frame. */
function rootPath({ joints, parents, root, shown }) {
  const path = new Float32Array(shown * 3);
  for (let i = 0; i < shown; i++) {
    for (let k = 0; k < 3; k++) path[i * 3 + k] = joints.after[(i * parents.length + root) * 3 + k];
  }
  return path;
}

/** The seam at both ends of the timeline. */
function drawSeam(context, theme, timeline) {
  const { motion } = timeline;
  if (!motion.round) return;
  context.font = theme.small;
  context.fillStyle = context.strokeStyle = theme.fair;
  context.textBaseline = "alphabetic";
  for (const [frame, align, gap] of [[0, "left", 3], [motion.frames - (motion.round.closed ? 1 : 0), "right", -3]]) {
    timeline.line(context, frame, theme.fair, 2, [], timeline.top(timeline.rows) - GAP + 4);
    const x = timeline.x(frame);
    if (x < timeline.gutter - 1 || x > timeline.right + 1) continue;
    context.textAlign = align;
    context.fillText("seam", x + gap, timeline.top(timeline.rows) - GAP + 10);
  }
}

// The motion out of the page's text: the other half of pack.py.

/**
 * Second differences, zigzag-folded, in 7-bit groups, back to numbers.
 * Returns a Float32Array (length, series): all series of one sample lie together.
 */
function unpack(text, length, series, quantum) {
  const raw = atob(text);
  const out = new Float32Array(length * series);
  let at = 0;
  for (let s = 0; s < series; s++) {
    let value = 0;
    let step = 0;
    for (let i = 0; i < length; i++) {
      let folded = 0;
      let shift = 0;
      let byte;
      do {
        byte = raw.charCodeAt(at++);
        folded |= (byte & 127) << shift;
        shift += 7;
      } while (byte > 127);
      step += (folded >>> 1) ^ -(folded & 1);
      value += step;
      out[i * series + s] = value * quantum;
    }
  }
  return out;
}

/** The figure before and after: metres, y up, `shown` frames of the clip's `frames`, every `step`-th. */
function readMotion(packed) {
  const { shown, parents, soles, quantum } = packed;
  const joints = parents.length;
  const before = unpack(packed.joints.before, shown, joints * 3, quantum.joints);
  const points = { before: unpack(packed.points.before, shown, soles.length * 3, quantum.points) };
  const speeds = { before: unpack(packed.speeds.before, shown, soles.length, quantum.speeds) };
  points.after = packed.points.after === null
    ? points.before : unpack(packed.points.after, shown, soles.length * 3, quantum.points);
  speeds.after = packed.speeds.after === null
    ? speeds.before : unpack(packed.speeds.after, shown, soles.length, quantum.speeds);
  const drawn = [...new Set(packed.bones.flat())];
  if (!drawn.length) drawn.push(...packed.parents.keys());
  return {
    ...packed,
    meshes: packed.meshes || [], // the soles of a skin
    ground: packed.ground === null ? null : unpack(packed.ground, shown, 3, quantum.points),
    drawn, // the joints that a bone goes to: of what stays behind at the origin there is none
    joints: { before, after: corrected(before, packed.joints, shown, joints, quantum.joints) },
    points,
    speeds,
    size: sizeOf(before, { shown, joints, drawn, floor: packed.floor }),
  };
}

/** Joints after correction: all go with the root's shift, those that `moved` by a shift of their own too. */
function corrected(before, packed, shown, joints, quantum) {
  if (packed.shift === null) return before;
  const shift = unpack(packed.shift, shown, 3, quantum);
  const own = unpack(packed.own, shown, packed.moved.length * 3, quantum);
  const after = new Float32Array(before);
  const { moved } = packed;
  for (let i = 0; i < shown; i++) {
    const [dx, dy, dz] = [shift[i * 3], shift[i * 3 + 1], shift[i * 3 + 2]];
    for (let at = i * joints * 3; at < (i + 1) * joints * 3; at += 3) {
      after[at] += dx;
      after[at + 1] += dy;
      after[at + 2] += dz;
    }
    for (let m = 0; m < moved.length; m++) {
      const [to, from] = [(i * joints + moved[m]) * 3, (i * moved.length + m) * 3];
      for (let k = 0; k < 3; k++) after[to + k] += own[from + k];
    }
  }
  return after;
}

/** How large the figure usually is: `height` above its floor and `radius` about its middle. */
function sizeOf(positions, { shown, joints, drawn, floor }) {
  const sizes = { height: [], radius: [] };
  for (let i = 0; i < shown; i += Math.max(1, Math.floor(shown / 50))) {
    const [low, high] = bounds(positions, i * joints, drawn);
    sizes.height.push(high[1] - Math.min(floor, low[1]));
    sizes.radius.push(Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2);
  }
  const usual = (values, rank) => Math.max(values.sort((a, b) => a - b)[Math.floor(values.length * rank)] || 1, 0.05);
  return { height: usual(sizes.height, 0.5), radius: usual(sizes.radius, 0.9) };
}

/** The corners of the box about the joints that are drawn; `base` is the first joint of a frame. */
function bounds(positions, base, drawn) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const joint of drawn) {
    for (let k = 0; k < 3; k++) {
      const value = positions[(base + joint) * 3 + k];
      low[k] = Math.min(low[k], value);
      high[k] = Math.max(high[k], value);
    }
  }
  return [low, high];
}

// The soles of a skin: outlines of parts of the feet, each placed by three places that move with it.

/** The corners of a part of a sole, in the world. */
function soleCorners(stage, part, when) {
  const { joints, points } = stage.motion;
  const placed = ([kind, k]) => (kind === "point" ? stage.point(points[when], k) : stage.joint(joints[when], k));
  const [at, to, beside] = [part.at, part.to, part.beside].map(placed);
  const less = (a, b) => a.map((value, k) => value - b[k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((value) => value / Math.max(Math.hypot(...a), 1e-9));
  const first = unit(less(to, at));
  const third = unit(cross(first, less(beside, at)));
  const axes = [first, cross(third, first), third];
  return part.outline.map((corner) =>
    at.map((value, k) => value + (corner[0] * axes[0][k] + corner[1] * axes[1][k] + corner[2] * axes[2][k]) / 1000));
}

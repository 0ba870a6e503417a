// The curves of the timeline: height and speed; over a long time the range of the height, and how far plants slide.

function drawCurves(timeline, context, theme, lane) {
  const { motion } = timeline;
  const { height, speed, bottom } = timeline.axis;
  const top = timeline.top(lane) + LANE;
  const rise = (HEIGHT_PLOT - 6) / (height - bottom);
  const heightAt = (metres) => top + HEIGHT_PLOT - 2 - (metres - bottom) * rise;
  const base = top + HEIGHT_PLOT + SPEED_PLOT;
  const speedAt = (value) => base - (value * (SPEED_PLOT - 4)) / speed;
  rule(timeline, context, theme, heightAt(0), []);
  rule(timeline, context, theme, base, []);
  if (motion.lines.height <= height) rule(timeline, context, theme, heightAt(motion.lines.height), [1, 3]);
  if (timeline.dense) drawSlides(timeline, context, theme, lane, base);
  else if (motion.lines.speed <= speed) rule(timeline, context, theme, speedAt(motion.lines.speed), [1, 3]);
  const lanes = motion.soles.length;
  for (const when of ["before", "after"]) {
    const color = when === "before" ? theme.was : timeline.color(theme, lane);
    const points = motion.points[when];
    const speeds = motion.speeds[when];
    const up = (i) => heightAt(points[(i * lanes + lane) * 3 + 1] - motion.floor);
    if (timeline.dense) envelope(timeline, context, up, color, when, top, HEIGHT_PLOT);
    else {
      curve(timeline, context, up, color, when, top, HEIGHT_PLOT);
      curve(timeline, context, (i) => speedAt(speeds[i * lanes + lane]), color, when, top + HEIGHT_PLOT, SPEED_PLOT + 2);
    }
  }
}

/** A level line through a plot. */
function rule(timeline, context, theme, y, dash) {
  context.beginPath();
  context.moveTo(timeline.gutter, y);
  context.lineTo(timeline.right, y);
  context.setLineDash(dash);
  context.strokeStyle = theme.axis;
  context.lineWidth = 1;
  context.stroke();
  context.setLineDash([]);
}

/** The shown frames that the window holds, and one on either side: [first, last]. */
function framesShown({ motion, window }) {
  const { step, shown } = motion;
  return [Math.max(0, Math.floor(window[0] / step) - 1), Math.min(shown - 1, Math.ceil(window[1] / step) + 1)];
}

/** For columns of `wide` pixels the range of a curve: [[x, lowest, highest], ...]. */
function ranges(timeline, y, wide) {
  const [first, last] = framesShown(timeline);
  const found = [];
  for (let i = first; i <= last; i++) {
    const [x, value] = [wide * Math.round(timeline.x(i * timeline.motion.step) / wide), y(i)];
    const open = found[found.length - 1];
    if (open && open[0] === x) [open[1], open[2]] = [Math.min(open[1], value), Math.max(open[2], value)];
    else found.push([x, value, value]);
  }
  return found;
}

/** A curve over the window; where samples are closer than pixels, the range within each pixel. */
function curve(timeline, context, y, color, when, top, tall) {
  const [first, last] = framesShown(timeline);
  const dense = (last - first) / (timeline.right - timeline.gutter) > 2;
  context.save();
  context.beginPath();
  context.rect(timeline.gutter, top, timeline.right - timeline.gutter, tall);
  context.clip();
  context.beginPath();
  if (dense) for (const [x, low, high] of ranges(timeline, y, 1)) context.lineTo(x, low), context.lineTo(x, high);
  else for (let i = first; i <= last; i++) context.lineTo(timeline.x(i * timeline.motion.step), y(i));
  context.strokeStyle = color;
  context.lineWidth = when === "before" ? 1.3 : 1.7;
  context.lineJoin = "round";
  context.setLineDash(when === "before" && !dense ? [4, 3] : []);
  context.stroke();
  context.restore();
}

/** The range of a curve as a ground, with a line along the end that lies on the floor. */
function envelope(timeline, context, y, color, when, top, tall) {
  const columns = ranges(timeline, y, 4);
  context.save();
  context.beginPath();
  context.rect(timeline.gutter, top, timeline.right - timeline.gutter, tall);
  context.clip();
  context.beginPath();
  for (const [x, low] of columns) context.lineTo(x, low);
  for (const [x, , high] of [...columns].reverse()) context.lineTo(x, high);
  context.closePath();
  context.fillStyle = color;
  context.globalAlpha = when === "before" ? 0.22 : 0.4;
  context.fill();
  context.globalAlpha = 1;
  context.beginPath();
  for (const [x, , high] of columns) context.lineTo(x, high); // y points downwards: the highest value is the lowest place
  context.strokeStyle = color;
  context.lineWidth = 1.2;
  context.stroke();
  context.restore();
}

/** How far each plant of a lane slides: before as a ground, after in front of it; the line is what viewers notice. */
function drawSlides(timeline, context, theme, lane, base) {
  const { contacts, tops } = timeline;
  const up = (mm) => (Math.min(mm, tops.slide) * (SPEED_PLOT - 4)) / tops.slide;
  for (const contact of contacts.lanes[lane]) {
    const found = contacts.outcome(lane, contact);
    if (!found) continue;
    const [left, right] = [timeline.x(contact.start), timeline.x(contact.end)];
    const wide = Math.max(right - left, 2);
    context.fillStyle = theme.was;
    context.globalAlpha = 0.5;
    context.fillRect(left, base - up(found.before || 0), wide, up(found.before || 0));
    context.globalAlpha = 1;
    context.fillStyle = found.after > 1000 * NOTICED ? theme.fair : timeline.color(theme, lane);
    context.fillRect(left, base - up(found.after || 0), wide, up(found.after || 0));
  }
  rule(timeline, context, theme, base - up(1000 * NOTICED), [1, 3]);
}

// From above: the way of the root before and after, the path it was led along, and by how far they differ over time.

/** A line through places [x, y] of the canvas. */
function drawLine(context, places, color, width, dash) {
  context.beginPath();
  for (const [x, y] of places) context.lineTo(x, y);
  context.setLineDash(dash);
  context.strokeStyle = color;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

class PathMap {
  constructor(canvas, motion, player, contacts) {
    Object.assign(this, { canvas, motion, player, contacts, still: new Still() });
    contacts.listeners.add(() => {
      this.still.stale = true;
    });
    this.before = this.track(motion.joints.before);
    this.after = this.track(motion.joints.after);
    this.asked = motion.path || []; // [x, z] of the path that was to be walked
    const span = (k) => {
      let [low, high] = [Infinity, -Infinity];
      for (const track of [this.before, this.after, this.asked]) {
        for (const place of track) [low, high] = [Math.min(low, place[k]), Math.max(high, place[k])];
      }
      return [low, high];
    };
    const reach = motion.size.height * 0.25; // feet stand beside the root's way
    this.box = [span(0), span(1)].map(([low, high]) => [low - reach, high + reach]);
    canvas.addEventListener("click", (event) => this.jump(event));
  }

  /** [x, z] of the root at every shown frame. */
  track(positions) {
    const { shown, parents, root } = this.motion;
    return Array.from({ length: shown }, (_, i) => {
      const at = (i * parents.length + root) * 3;
      return [positions[at], positions[at + 2]];
    });
  }

  /** From the world to the canvas: x to the right, z downwards, as seen from above. */
  place() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const [[x0, x1], [z0, z1]] = this.box;
    // A long way lies along the wide side, whichever way it went.
    const turned = z1 - z0 > x1 - x0;
    const [a0, a1, b0, b1] = turned ? [z0, z1, x0, x1] : [x0, x1, z0, z1];
    const scale = Math.min((width - 24) / (a1 - a0), (height - 52) / (b1 - b0));
    const [ox, oy] = [(width - scale * (a1 - a0)) / 2, (height - 28 - scale * (b1 - b0)) / 2];
    const spot = ([x, z]) => {
      const [a, b] = turned ? [z, x] : [x, z];
      return [ox + scale * (a - a0), oy + scale * (b - b0)];
    };
    return { scale, spot };
  }

  draw(theme) {
    const { context, width, height } = fit(this.canvas);
    const { scale, spot } = this.place();
    this.still.show(context, (still) => {
      still.lineJoin = still.lineCap = "round";
      this.drawPlants(still, theme, spot);
      if (this.asked.length) drawLine(still, this.asked.map(spot), theme.muted, 5, []);
      drawLine(still, this.before.map(spot), theme.was, 1.6, [5, 4]);
      drawLine(still, this.after.map(spot), theme.ink, 1.8, []);
      this.drawScale(still, theme, scale, width, height);
    });
    const [x, y] = spot(this.after[this.player.index]);
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = theme.ink;
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = theme.stage;
    context.stroke();
  }

  /** Where heels and toes stand, after. */
  drawPlants(context, theme, spot) {
    const { motion, contacts } = this;
    contacts.lanes.forEach((lane, k) => {
      if (k >= motion.soles.length) return;
      context.fillStyle = sideColor(theme, contacts.effectors[k]);
      for (const contact of lane) {
        if (wishOf(contact) === "forbid") continue;
        const i = Math.min(motion.shown - 1, Math.round((contact.start + contact.end) / 2 / motion.step));
        const at = (i * motion.soles.length + k) * 3;
        const [x, y] = spot([motion.points.after[at], motion.points.after[at + 2]]);
        context.beginPath();
        context.arc(x, y, contacts.effectors[k].part === "heel" ? 3 : 2, 0, 2 * Math.PI);
        context.fill();
      }
    });
  }

  drawScale(context, theme, scale, width, height) {
    const length = roundStep(((width - 24) * 0.3) / scale);
    const y = height - 8;
    context.beginPath();
    context.moveTo(12, y - 4);
    context.lineTo(12, y);
    context.lineTo(12 + length * scale, y);
    context.lineTo(12 + length * scale, y - 4);
    context.strokeStyle = theme.muted;
    context.lineWidth = 1.2;
    context.stroke();
    context.font = theme.small;
    context.fillStyle = theme.muted;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    context.fillText(length >= 1 ? `${length} m` : `${Math.round(length * 100)} cm`, 12 + length * scale + 6, y);
  }

  jump(event) {
    const box = this.canvas.getBoundingClientRect();
    const { spot } = this.place();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [best, nearest] = [0, Infinity];
    this.after.forEach((place, i) => {
      const [px, py] = spot(place);
      const distance = Math.hypot(px - x, py - y);
      if (distance < nearest) [best, nearest] = [i, distance];
    });
    this.player.pause();
    this.player.seek(best * this.motion.step);
  }
}

/** How far the root was moved, over time: over the floor and upwards, in millimetres. */
class DriftPlot {
  constructor(canvas, motion, player) {
    Object.assign(this, { canvas, motion, player, still: new Still() });
    const { shown, parents, root, joints } = motion;
    this.across = new Float32Array(shown);
    this.upwards = new Float32Array(shown);
    for (let i = 0; i < shown; i++) {
      const at = (i * parents.length + root) * 3;
      const [dx, dy, dz] = [0, 1, 2].map((k) => 1000 * (joints.after[at + k] - joints.before[at + k]));
      this.across[i] = Math.hypot(dx, dz);
      this.upwards[i] = dy;
    }
    const least = (values) => values.reduce((a, b) => Math.min(a, b), 0);
    const most = (values) => values.reduce((a, b) => Math.max(a, b), 0);
    this.low = least(this.upwards);
    this.moves = this.across.some(Boolean) || this.upwards.some(Boolean);
    this.high = Math.max(most(this.across), most(this.upwards), 1);
    canvas.addEventListener("click", (event) => {
      const share = (event.clientX - canvas.getBoundingClientRect().left - 64) / (canvas.clientWidth - 76);
      player.pause();
      player.seek(share * (motion.shown - 1) * motion.step);
    });
  }

  draw(theme) {
    const { context, width, height } = fit(this.canvas);
    const x = (i) => 64 + ((width - 76) * i) / Math.max(this.motion.shown - 1, 1);
    this.still.show(context, (still) => this.drawStill(still, theme, x, width, height));
    const now = x(this.player.index);
    drawLine(context, [[now, 6], [now, height - 6]], theme.ink, 1.2, []);
  }

  drawStill(context, theme, x, width, height) {
    const { shown } = this.motion;
    const y = (value) => height - 12 - ((height - 24) * (value - this.low)) / (this.high - this.low);
    context.font = theme.small;
    context.textAlign = "right";
    context.textBaseline = "middle";
    const apart = (value) => value === 0 || Math.abs(y(value) - y(0)) > 16;
    const marks = [0, this.high, this.low].filter((value, k) => (k === 0 || value !== 0) && apart(value));
    for (const value of marks) {
      context.fillStyle = theme.muted;
      context.fillText(`${value.toFixed(0)} mm`, 56, y(value));
      drawLine(context, [[64, y(value)], [width - 12, y(value)]], theme.line, 1, []);
    }
    const every = Math.max(1, Math.floor(shown / 1500));
    const series = (values) => {
      const places = [];
      for (let i = 0; i < shown; i += every) places.push([x(i), y(values[i])]);
      return places;
    };
    drawLine(context, series(this.upwards), theme.muted, 1.3, [1.5, 3]);
    drawLine(context, series(this.across), theme.ink, 1.6, []);
  }
}

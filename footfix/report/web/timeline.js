// The timeline: for each heel and toe its contacts and its curves, and below them the change of the knees.

const LANE = 18; // heights in CSS pixels
const HEIGHT_PLOT = 46;
const SPEED_PLOT = 30;
const GAP = 14;
const RULER = 24;
const DENSE = 0.04; // [s] a pixel from which on steps run together: then envelopes and slides are shown
const GRIP = 7; // how near to an end of a bar a pointer has to be; twice that for a finger

class Timeline {
  constructor(canvas, motion, player, contacts) {
    Object.assign(this, { canvas, motion, player, contacts });
    this.window = [0, motion.frames];
    this.whole = false; // whether the curves show their whole range, or what is near the floor
    this.editing = false;
    this.hover = null; // {frame, lane}
    this.draft = null; // {lane, contact, old} while a contact is dragged
    this.rows = Math.min(contacts.effectors.length, motion.soles.length);
    this.still = new Still(); // all but the playhead
    this.knees = kneeRows(motion);
    canvas.style.height = `${this.bottom + 4}px`;
    this.tops = this.rangeTops();
    [this.gutter, this.right] = [96, canvas.clientWidth - 12];
  }

  /** The top of the height and speed axes: near the floor, and over everything. */
  rangeTops() {
    const { motion } = this;
    let [high, fast, low] = [0, 0, 0];
    for (const when of ["before", "after"]) {
      for (let i = 1; i < motion.points[when].length; i += 3) {
        high = Math.max(high, motion.points[when][i] - motion.floor);
        low = Math.min(low, motion.points[when][i] - motion.floor);
      }
      for (const speed of motion.speeds[when]) fast = Math.max(fast, speed);
    }
    const near = {
      height: Math.max(roundStep(motion.size.height * 0.13), 2 * motion.lines.height),
      speed: Math.max(roundStep(motion.size.height * 0.7), 2 * motion.lines.speed),
    };
    near.bottom = Math.max(low, -near.height / 4);
    return {
      near,
      whole: { height: Math.max(high, 0.01), speed: Math.max(fast, 0.1), bottom: Math.min(low, 0) },
      slide: Math.round(3000 * NOTICED), // [mm]; longer ones are cut off, so that those near what is noticed are seen
    };
  }

  // ---- places --------------------------------------------------------------------------------------

  /** Where the curves begin and end: right of the longest name. Kept, since to ask a page for sizes is slow. */
  measure(context, theme, width) {
    context.font = theme.strong;
    const names = this.contacts.effectors.slice(0, this.rows).map((each) => context.measureText(named(each)).width);
    this.gutter = Math.min(Math.max(width < 560 ? 74 : 96, ...names.map((each) => each + 14)), width * 0.35);
    this.right = width - 12;
  }

  x(frame) {
    const [from, to] = this.window;
    return this.gutter + ((frame - from) / (to - from)) * (this.right - this.gutter);
  }

  frameAt(x) {
    const [from, to] = this.window;
    return from + ((x - this.gutter) / (this.right - this.gutter)) * (to - from);
  }

  top(lane) {
    return RULER + lane * (LANE + HEIGHT_PLOT + SPEED_PLOT + GAP);
  }

  /** The top of a row of knees. */
  kneeTop(row) {
    return this.top(this.rows) + row * (KNEE_PLOT + GAP);
  }

  get bottom() {
    return this.kneeTop(this.knees.length);
  }

  /** Whether so much time is shown that curves would be a smear. */
  get dense() {
    const [from, to] = this.window;
    return ((to - from) * this.motion.frameTime) / (this.right - this.gutter) > DENSE;
  }

  /** The row of knees at a height of the canvas, or null. */
  kneesAt(y) {
    return this.knees[Math.floor((y - this.kneeTop(0)) / (KNEE_PLOT + GAP))] || null;
  }

  laneAt(y) {
    const lane = Math.floor((y - RULER) / (LANE + HEIGHT_PLOT + SPEED_PLOT + GAP));
    return lane >= 0 && lane < this.rows ? lane : null;
  }

  /** Shows the frames [from, to), at least eight of them. */
  zoomTo(from, to) {
    const { frames } = this.motion;
    const length = Math.min(frames, Math.max(8, to - from));
    const start = Math.max(0, Math.min(frames - length, from));
    this.window = [start, start + length];
    this.still.stale = true;
  }

  /** Zooms about a frame. */
  zoom(factor, about = this.player.frame) {
    const [from, to] = this.window;
    this.zoomTo(about - (about - from) * factor, about + (to - about) * factor);
  }

  /** Turns the page when the playhead runs out of the window. */
  keepPlayhead() {
    const [from, to] = this.window;
    const { frame } = this.player;
    const moved = frame !== this.kept; // one who looks elsewhere while it stands is left alone
    this.kept = frame;
    if (!moved || this.draft || (frame >= from && frame <= to)) return;
    this.zoomTo(frame - (to - from) * 0.1, frame + (to - from) * 0.9);
  }

  // ---- drawing -------------------------------------------------------------------------------------

  draw(theme) {
    this.keepPlayhead();
    const { context, width, height } = fit(this.canvas);
    this.still.show(context, (still) => {
      this.measure(still, theme, width);
      this.drawStill(still, theme);
    });
    if (this.hover) this.line(context, this.hover.frame, theme.muted, 1, [2, 3], height);
    this.line(context, this.player.frame, theme.ink, 1.5, [], height);
    const x = this.x(this.player.frame);
    if (x < this.gutter - 1 || x > this.right + 1) return;
    context.beginPath();
    context.moveTo(x - 6, RULER - 12);
    context.lineTo(x + 6, RULER - 12);
    context.lineTo(x, RULER - 4);
    context.closePath();
    context.fillStyle = theme.ink;
    context.fill();
  }

  line(context, frame, color, width, dash, height) {
    const x = this.x(frame);
    if (x < this.gutter - 1 || x > this.right + 1) return;
    context.beginPath();
    context.moveTo(x, RULER - 8);
    context.lineTo(x, height - 4);
    context.setLineDash(dash);
    context.strokeStyle = color;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  drawStill(context, theme) {
    this.drawRuler(context, theme);
    drawSeam(context, theme, this);
    for (let lane = 0; lane < this.rows; lane++) {
      this.drawLabels(context, theme, lane);
      context.save();
      context.beginPath();
      context.rect(this.gutter, this.top(lane), this.right - this.gutter, LANE + HEIGHT_PLOT + SPEED_PLOT + GAP);
      context.clip();
      this.drawTints(context, theme, lane);
      drawCurves(this, context, theme, lane);
      this.drawBars(context, theme, lane);
      context.restore();
    }
    this.knees.forEach((row, k) => drawKnees(this, context, theme, row, this.kneeTop(k)));
  }

  drawRuler(context, theme) {
    const [from, to] = this.window.map((frame) => frame * this.motion.frameTime);
    const wide = this.right - this.gutter;
    const step = roundStep(((to - from) / wide) * 150);
    context.font = theme.small;
    context.fillStyle = theme.muted;
    context.strokeStyle = theme.line;
    context.lineWidth = 1;
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    for (let k = Math.ceil(from / step); k * step <= to + 1e-9; k++) {
      const x = this.x((k * step) / this.motion.frameTime);
      const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
      if (x < this.right - 14) context.fillText(`${(k * step).toFixed(digits)} s`, x, 10);
      context.beginPath();
      context.moveTo(x, RULER - 8);
      context.lineTo(x, this.bottom - GAP);
      context.stroke();
    }
  }

  drawLabels(context, theme, lane) {
    const effector = this.contacts.effectors[lane];
    const { height, speed } = this.axis;
    const [x, top] = [this.gutter - 8, this.top(lane)];
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.font = theme.strong;
    context.fillStyle = sideColor(theme, effector);
    context.fillText(shorten(context, named(effector), this.gutter - 10), x, top + LANE / 2);
    context.font = theme.small;
    context.fillStyle = theme.muted;
    const wide = this.gutter > 90;
    context.fillText(`${Number((height * 100).toPrecision(2))} cm`, x, top + LANE + 10);
    context.fillText(wide ? "height" : "h", x, top + LANE + HEIGHT_PLOT / 2 + 6);
    const { dense } = this;
    const most = dense ? `${this.tops.slide} mm` : `${Number(speed.toPrecision(2))} m/s`;
    context.fillText(most, x, top + LANE + HEIGHT_PLOT + 10);
    const second = dense ? "slide" : "speed";
    context.fillText(wide ? second : second[0], x, top + LANE + HEIGHT_PLOT + SPEED_PLOT - 5);
  }

  get axis() {
    return this.whole ? this.tops.whole : this.tops.near;
  }

  /** The stretches of contact as a faint ground behind the curves. */
  drawTints(context, theme, lane) {
    context.globalAlpha = 0.1;
    context.fillStyle = this.color(theme, lane);
    for (const contact of this.contacts.lanes[lane]) {
      if (wishOf(contact) === "forbid") continue;
      const [a, b] = [this.x(contact.start), this.x(contact.end)];
      context.fillRect(a, this.top(lane) + LANE, b - a, HEIGHT_PLOT + SPEED_PLOT);
    }
    context.globalAlpha = 1;
  }

  drawBars(context, theme, lane) {
    const { draft } = this;
    const { selection } = this.contacts;
    const contacts = this.contacts.lanes[lane].filter((each) => !draft || each !== draft.old);
    if (draft && draft.lane === lane) contacts.push(draft.contact);
    for (const contact of contacts) {
      const chosen = (draft && draft.contact === contact)
        || (selection && selection.lane === lane && selection.contact === contact);
      const [left, right] = [this.x(contact.start), this.x(contact.end)];
      const box = { x: left, y: this.top(lane) + 2, wide: Math.max(right - left, 1.5), tall: LANE - 5 };
      drawBar(context, theme, box, contact, this.color(theme, lane), chosen);
      if (this.contacts.outcome(lane, contact)?.after > 1000 * NOTICED) underline(context, theme, box);
      if (this.editing && chosen) for (const x of [left, right]) drawHandle(context, theme, x, box);
    }
  }

  color(theme, lane) {
    return sideColor(theme, this.contacts.effectors[lane]);
  }

  // ---- pointers ------------------------------------------------------------------------------------

  /** What lies under a pointer: the end of a bar, a bar, an empty stretch of a lane, or nothing. */
  hit(x, y, finger) {
    const lane = this.laneAt(y);
    if (lane === null || !this.editing || y > this.top(lane) + LANE + (finger ? 8 : 2)) return { kind: "none", lane };
    const grip = finger ? 2 * GRIP : GRIP;
    const nearest = { distance: grip };
    for (const contact of this.contacts.lanes[lane]) {
      for (const end of ["start", "end"]) {
        // Where two bars touch, the one that is chosen comes first.
        const chosen = this.contacts.selection?.contact === contact;
        const distance = Math.abs(this.x(contact[end]) - x) - (chosen ? 2 : 0);
        if (distance < nearest.distance) Object.assign(nearest, { distance, contact, end });
      }
    }
    if (nearest.contact) return { kind: "end", lane, contact: nearest.contact, end: nearest.end };
    const contact = this.contacts.at(lane, Math.floor(this.frameAt(x)));
    return contact ? { kind: "bar", lane, contact } : { kind: "empty", lane };
  }
}

/** A text cut with an ellipsis where it is too wide. */
function shorten(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let cut = text.length;
  while (cut > 1 && context.measureText(`${text.slice(0, cut)}…`).width > width) cut--;
  return `${text.slice(0, cut)}…`;
}

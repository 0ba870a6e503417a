// The stage: the figure before and after on its floor, drawn with a painter's order on a 2D canvas.

class Stage {
  constructor(canvas, motion, player, contacts) {
    Object.assign(this, { canvas, motion, player, contacts });
    this.figures = "both"; // "before", "both", "after" or "beside": side by side
    this.show = { trails: true, prints: true, follow: true };
    this.camera = new Camera(motion.size.radius);
    this.closeUp = null; // {target, radius} of a leg that is looked at, or null for the whole figure
    this.sides = sidesOf(motion);
    this.feet = feetOf(motion, contacts.effectors);
    this.seen = new Seen(motion, contacts);
    this.rounds = new Rounds(motion, player);
    this.path = motion.round ? this.rounds.path(rootPath(motion)) : smoothPath(motion);
    this.frame(null);
    this.view("three-quarter");
  }

  // ---- where to look -------------------------------------------------------------------------------

  restingTarget() {
    const at = this.player.index * 3;
    return [this.path[at], this.path[at + 1], this.path[at + 2]];
  }

  /** Looks at the figure from its front, side or top, or from three quarters. */
  view(name) {
    const heading = headingAt(this.motion, this.player.index);
    const turns = { front: 0, side: Math.PI / 2, top: 0, "three-quarter": 0.9 };
    const pitches = { front: 0.06, side: 0.06, top: Math.PI / 2 - 0.001, "three-quarter": 0.22 };
    this.camera.yaw = heading + turns[name];
    this.camera.pitch = pitches[name];
    this.camera.pan = [0, 0, 0];
  }

  /** Close up on a ball {target, radius}, or, with null, back to the whole figure. */
  frame(ball) {
    const { size } = this.motion;
    this.closeUp = ball;
    this.camera.pan = [0, 0, 0];
    this.camera.distance = 3.7 * (ball ? Math.max(ball.radius, 0.2 * size.height) : size.radius);
    this.camera.target = ball ? ball.target : this.restingTarget();
  }

  /** The ball about the whole leg of an effector, from hip to toes, through the frames [start, end). */
  legBall(lane, start, end) {
    const { motion, contacts } = this;
    const name = contacts.effectors[lane].name.replace(/_(heel|toe)$/, "");
    const leg = motion.legs.find((each) => each[3] === name);
    const joints = [...(leg ? leg.slice(0, 3) : []), motion.soles[lane]];
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    const take = (places, at) => {
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], places[at + k]);
        high[k] = Math.max(high[k], places[at + k]);
      }
    };
    const first = Math.min(motion.shown - 1, Math.round(start / motion.step));
    const last = Math.min(motion.shown - 1, Math.round(end / motion.step));
    for (let i = first; i <= last; i++) {
      for (const when of ["before", "after"]) {
        for (const joint of joints) take(motion.joints[when], (i * motion.parents.length + joint) * 3);
        take(motion.points[when], (i * motion.soles.length + lane) * 3);
      }
    }
    const radius = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2;
    return { target: low.map((value, k) => (value + high[k]) / 2), radius: Math.min(radius, motion.size.radius) };
  }

  // ---- drawing -------------------------------------------------------------------------------------

  draw(theme) {
    const { context, width, height } = fit(this.canvas);
    this.context = context;
    this.theme = theme;
    this.rounds.turn(this.camera);
    if (this.closeUp) this.camera.target = this.closeUp.target;
    else if (this.show.follow) this.camera.target = this.restingTarget();
    context.clearRect(0, 0, width, height);
    context.lineCap = context.lineJoin = "round";
    if (this.figures === "beside") {
      ["before", "after"].forEach((when, k) => this.drawHalf(when, (k * width) / 2, width / 2, height));
    } else {
      this.camera.aim(width, height);
      this.drawScene(this.figures === "before" ? "before" : "after", this.figures === "both");
      if (this.figures !== "both") this.drawTitle(this.figures);
    }
  }

  /** One figure in its half of the stage, seen as the other one. */
  drawHalf(when, left, width, height) {
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(left, 0, width, height);
    context.clip();
    context.translate(left, 0);
    this.camera.aim(width, height);
    this.drawScene(when, false);
    this.drawTitle(when);
    context.restore();
    if (left > 0) {
      context.fillStyle = this.theme.line;
      context.fillRect(left, 0, 1, height);
    }
  }

  drawTitle(when) {
    this.context.font = this.theme.strong;
    this.context.textAlign = "left";
    this.context.textBaseline = "top";
    this.context.fillStyle = when === "before" ? this.theme.was : this.theme.ink;
    this.context.fillText(when, 10, 8);
  }

  /** The figure before or after, and with `ghost` the one before behind the one after. */
  drawScene(when, ghost) {
    drawGrid(this);
    if (this.show.prints) drawPrints(this, when, ghost);
    drawChosen(this, when, ghost);
    drawShadow(this, when);
    if (this.show.trails) this.drawTrails(when, ghost);
    if (ghost) this.drawGhost();
    this.drawFigure(when);
  }

  joint(positions, joint) {
    const at = (this.player.index * this.motion.parents.length + joint) * 3;
    return [positions[at], positions[at + 1], positions[at + 2]];
  }

  point(points, lane, index = this.player.index) {
    if (index < 0) return this.rounds.moved(this.point(points, lane, index + roundLength(this.motion)), -1);
    if (index < 0) return this.rounds.moved(this.point(points, lane, index + roundLength(this.motion)), -1);
    const at = (index * this.motion.soles.length + lane) * 3;
    return [points[at], points[at + 1], points[at + 2]];
  }

  /** A line through places in the world. */
  trace(places, color, width, { dash = [], alpha = 1 } = {}) {
    const { context } = this;
    context.beginPath();
    let pen = false;
    for (const place of places) {
      const spot = this.camera.project(...place);
      if (!spot) pen = false;
      else if (pen) context.lineTo(spot[0], spot[1]);
      else {
        context.moveTo(spot[0], spot[1]);
        pen = true;
      }
    }
    context.setLineDash(dash);
    context.globalAlpha = alpha;
    context.strokeStyle = color;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  dot(place, radius, fill, stroke) {
    const spot = this.camera.project(...place);
    if (!spot) return;
    const { context } = this;
    context.beginPath();
    context.arc(spot[0], spot[1], radius, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.fill();
    if (stroke) {
      context.strokeStyle = stroke;
      context.lineWidth = 1.5;
      context.stroke();
    }
  }

  /** The way of each sole point through the last second. */
  drawTrails(when, ghost) {
    const { motion, player, theme } = this;
    const length = Math.round(1 / (motion.frameTime * motion.step));
    const earliest = player.rounds ? -roundLength(motion) : 0; // a trail goes on over the seam of a loop
    const first = Math.max(earliest, player.index - length);
    const track = (points, lane) => {
      const places = [];
      for (let i = first; i <= player.index; i++) places.push(this.point(points, lane, i));
      return places;
    };
    motion.soles.forEach((_, lane) => {
      if (ghost) this.trace(track(motion.points.before, lane), theme.was, 1.2, { dash: [4, 3], alpha: 0.8 });
      this.trace(track(motion.points[when], lane), this.sideColor(lane), 1.5, { alpha: 0.6 });
    });
  }

  drawGhost() {
    const { motion, theme, context } = this;
    const width = Math.max(1.2, Math.min(2.4, (this.camera.focal * motion.size.height * 0.006) / this.camera.distance));
    for (const [a, b] of motion.bones) {
      this.trace([this.joint(motion.joints.before, a), this.joint(motion.joints.before, b)], theme.was, width);
    }
    for (const foot of motion.meshes.length ? [] : this.feet) {
      const corners = this.footCorners(foot, "before");
      this.trace([...corners, corners[0]], theme.was, Math.max(1, width * 0.8));
    }
    for (const part of motion.meshes) {
      const corners = soleCorners(this, part, "before");
      this.trace([...corners, corners[0]], theme.was, 1, { alpha: 0.7 });
    }
    context.globalAlpha = 1;
  }

  /** Bones and feet, the farthest first. */
  drawFigure(when) {
    const { motion, camera } = this;
    const parts = [];
    for (const [a, b] of motion.bones) {
      const [p, q] = [this.joint(motion.joints[when], a), this.joint(motion.joints[when], b)];
      const line = camera.segment(p, q);
      if (line) parts.push({ depth: (line[0][2] + line[1][2]) / 2, draw: () => this.drawBone(line, this.sides[b]) });
    }
    for (const foot of motion.meshes.length ? [] : this.feet) {
      const corners = this.footCorners(foot, when).map((p) => camera.project(...p));
      if (corners.every(Boolean)) parts.push({ depth: corners[0][2], draw: () => this.drawFoot(corners, foot) });
    }
    for (const part of motion.meshes) {
      const corners = soleCorners(this, part, when).map((p) => camera.project(...p));
      const middle = corners[corners.length >> 1];
      if (corners.every(Boolean)) parts.push({ depth: middle[2], draw: () => this.drawFoot(corners, { heel: part.lane }) });
    }
    parts.sort((one, other) => other.depth - one.depth);
    for (const part of parts) part.draw();
    motion.soles.forEach((_, lane) => {
      const planted = this.contacts.lanes[lane] && this.contacts.planted(lane, this.player.frame);
      const color = this.sideColor(lane);
      const place = this.point(motion.points[when], lane);
      if (planted) this.dot(place, 5.5, color, this.theme.stage);
      else this.dot(place, 2.5, this.theme.stage, color);
    });
  }

  drawBone([from, to], side) {
    const { context, camera, motion, theme } = this;
    const depth = (from[2] + to[2]) / 2;
    const width = Math.max(2, Math.min(9, (camera.focal * motion.size.height * 0.013) / depth));
    const line = () => {
      context.beginPath();
      context.moveTo(from[0], from[1]);
      context.lineTo(to[0], to[1]);
      context.stroke();
    };
    context.lineWidth = width + 2; // a rim, so that limbs that cross stay apart
    context.strokeStyle = theme.stage;
    line();
    context.lineWidth = width;
    context.strokeStyle = side === "left" ? theme.left : side === "right" ? theme.right : theme.bone;
    line();
  }

  drawFoot(corners, foot) {
    const { context } = this;
    const color = this.sideColor(foot.heel);
    context.beginPath();
    corners.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    context.globalAlpha = 0.3;
    context.fillStyle = color;
    context.fill();
    context.globalAlpha = 1;
    context.lineWidth = 2;
    context.strokeStyle = color;
    context.stroke();
  }

  footCorners(foot, when) {
    const { joints, points } = this.motion;
    return [this.joint(joints[when], foot.ankle), this.point(points[when], foot.heel), this.point(points[when], foot.toe)];
  }

  sideColor(lane) {
    return sideColor(this.theme, this.contacts.effectors[lane]);
  }
}

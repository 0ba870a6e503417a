// The stage: the figure before and after on its floor, drawn with a painter's order on a 2D canvas.

class Stage {
  constructor(canvas, motion, player, contacts) {
    Object.assign(this, { canvas, motion, player, contacts });
    this.show = { before: true, trails: true, prints: true, follow: true };
    this.camera = new Camera(motion.size.radius);
    this.closeUp = null; // [x, y, z] of a plant that is looked at, or null for the whole figure
    this.bones = motion.parents.flatMap((parent, joint) => (parent >= 0 ? [[parent, joint]] : []));
    this.sides = sidesOf(motion);
    this.feet = feetOf(motion, contacts.effectors);
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

  /** Close up on a place on the floor, or, with null, back to the whole figure. */
  frame(place) {
    this.closeUp = place;
    this.camera.pan = [0, 0, 0];
    this.camera.distance = place ? this.motion.size.height * 0.75 : this.motion.size.radius * 3.7;
    this.camera.target = place || this.restingTarget();
  }

  // ---- drawing -------------------------------------------------------------------------------------

  draw(theme) {
    const { context, width, height } = fit(this.canvas);
    this.context = context;
    this.theme = theme;
    this.rounds.turn(this.camera);
    if (this.closeUp) this.camera.target = this.closeUp;
    else if (this.show.follow) this.camera.target = this.restingTarget();
    this.camera.aim(width, height);
    context.clearRect(0, 0, width, height);
    context.lineCap = context.lineJoin = "round";
    this.drawGrid();
    if (this.show.prints) this.drawPrints();
    this.drawChosen();
    this.drawShadow();
    if (this.show.trails) this.drawTrails();
    if (this.show.before) this.drawGhost();
    this.drawFigure();
  }

  joint(positions, joint) {
    const at = (this.player.index * this.motion.parents.length + joint) * 3;
    return [positions[at], positions[at + 1], positions[at + 2]];
  }

  point(points, lane, index = this.player.index) {
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

  /** Floor squares that grow with the distance, fading out away from the target. */
  drawGrid() {
    const { camera, context } = this;
    this.square = roundStep(camera.distance * 0.11);
    const reach = 14;
    const { rounds } = this;
    const under = rounds.out(camera.target.map((t, k) => t + camera.pan[k]));
    const [cx, cz] = [Math.round(under[0] / this.square), Math.round(under[2] / this.square)];
    const floor = this.motion.floor;
    context.strokeStyle = this.theme.line;
    context.lineWidth = 1;
    const layers = [[], [], [], []];
    for (let a = -reach; a <= reach; a++) {
      for (let b = -reach; b < reach; b++) {
        const away = Math.hypot(a, b + 0.5) / reach;
        if (away >= 1) continue;
        const layer = layers[Math.floor(away * 4)];
        const [u, v, w] = [a * this.square, b * this.square, (b + 1) * this.square];
        const [ox, oz] = [cx * this.square, cz * this.square];
        layer.push([[ox + u, floor, oz + v], [ox + u, floor, oz + w]]);
        layer.push([[ox + v, floor, oz + u], [ox + w, floor, oz + u]]);
      }
    }
    layers.forEach((segments, k) => {
      context.beginPath();
      for (const [a, b] of segments) {
        const line = camera.segment(rounds.home(a), rounds.home(b));
        if (!line) continue;
        context.moveTo(line[0][0], line[0][1]);
        context.lineTo(line[1][0], line[1][1]);
      }
      context.globalAlpha = [1, 0.75, 0.45, 0.2][k];
      context.stroke();
    });
    context.globalAlpha = 1;
  }

  /** Where each planted heel and toe stands: its way over the floor before, its place after. */
  drawPrints() {
    const { motion, player, theme } = this;
    const near = 4 / motion.frameTime;
    const thick = Math.max(1.5, Math.min(4, this.camera.focal * motion.size.height * 0.004 / this.camera.distance));
    this.contacts.lanes.forEach((lane, k) => {
      if (k >= motion.soles.length) return;
      for (const contact of lane) {
        if (wishOf(contact) === "forbid") continue;
        const away = Math.max(contact.start - player.frame, player.frame - contact.end, 0);
        if (away > near) continue;
        const alpha = away === 0 ? 1 : 0.55 * (1 - away / near) + 0.1;
        const was = this.printOf(motion.points.before, k, contact);
        const is = this.printOf(motion.points.after, k, contact);
        if (this.show.before) this.trace(was, theme.was, thick, { alpha });
        this.trace(is, this.sideColor(k), thick, { alpha });
        this.context.globalAlpha = alpha;
        this.dot(is[is.length >> 1], thick * 1.7, this.sideColor(k), theme.stage);
        this.context.globalAlpha = 1;
      }
    });
  }

  /** The plant that is looked at: its way before and after, and around its place how far viewers let it slide. */
  drawChosen() {
    const { selection } = this.contacts;
    if (!selection || selection.lane >= this.motion.soles.length) return;
    const { lane, contact } = selection;
    const is = this.printOf(this.motion.points.after, lane, contact);
    const [x, y, z] = is[is.length >> 1];
    const ring = Array.from({ length: 49 }, (_, k) => {
      const turn = (k / 48) * 2 * Math.PI;
      return [x + NOTICED * Math.cos(turn), y, z + NOTICED * Math.sin(turn)];
    });
    this.trace(ring, this.theme.ink, 1.2, { dash: [3, 3] });
    this.trace(this.printOf(this.motion.points.before, lane, contact), this.theme.was, 3);
    this.trace(is, this.sideColor(lane), 3);
  }

  /** The way of a sole point over the floor during a contact, at the height it has on average. */
  printOf(points, lane, contact) {
    const { step, shown } = this.motion;
    const first = Math.min(shown - 1, Math.ceil(contact.start / step));
    const last = Math.max(first, Math.min(shown - 1, Math.ceil(contact.end / step) - 1));
    const places = [];
    for (let i = first; i <= last; i++) places.push(this.point(points, lane, i));
    const height = places.reduce((sum, place) => sum + place[1], 0) / places.length;
    return places.map(([x, , z]) => [x, height, z]);
  }

  drawShadow() {
    const { motion, context, camera } = this;
    context.beginPath();
    for (const [a, b] of this.bones) {
      const [p, q] = [this.joint(motion.joints.after, a), this.joint(motion.joints.after, b)];
      const line = camera.segment([p[0], motion.floor, p[2]], [q[0], motion.floor, q[2]]);
      if (!line) continue;
      context.moveTo(line[0][0], line[0][1]);
      context.lineTo(line[1][0], line[1][1]);
    }
    context.lineWidth = Math.max(3, Math.min(18, (camera.focal * motion.size.height * 0.03) / camera.distance));
    context.strokeStyle = this.theme.shadow;
    context.stroke();
  }

  /** The way of each sole point through the last second. */
  drawTrails() {
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
      if (this.show.before) this.trace(track(motion.points.before, lane), theme.was, 1.2, { dash: [4, 3], alpha: 0.8 });
      this.trace(track(motion.points.after, lane), this.sideColor(lane), 1.5, { alpha: 0.6 });
    });
  }

  drawGhost() {
    const { motion, theme, context } = this;
    const width = Math.max(1.2, Math.min(2.4, (this.camera.focal * motion.size.height * 0.006) / this.camera.distance));
    for (const [a, b] of this.bones) {
      this.trace([this.joint(motion.joints.before, a), this.joint(motion.joints.before, b)], theme.was, width);
    }
    for (const foot of this.feet) {
      const corners = this.footCorners(foot, motion.joints.before, motion.points.before);
      this.trace([...corners, corners[0]], theme.was, Math.max(1, width * 0.8));
    }
    context.globalAlpha = 1;
  }

  /** Bones and feet, the farthest first. */
  drawFigure() {
    const { motion, camera } = this;
    const parts = [];
    for (const [a, b] of this.bones) {
      const [p, q] = [this.joint(motion.joints.after, a), this.joint(motion.joints.after, b)];
      const line = camera.segment(p, q);
      if (line) parts.push({ depth: (line[0][2] + line[1][2]) / 2, draw: () => this.drawBone(line, this.sides[b]) });
    }
    for (const foot of this.feet) {
      const corners = this.footCorners(foot, motion.joints.after, motion.points.after).map((p) => camera.project(...p));
      if (corners.every(Boolean)) parts.push({ depth: corners[0][2], draw: () => this.drawFoot(corners, foot) });
    }
    parts.sort((one, other) => other.depth - one.depth);
    for (const part of parts) part.draw();
    motion.soles.forEach((_, lane) => {
      const planted = this.contacts.lanes[lane] && this.contacts.planted(lane, this.player.frame);
      const color = this.sideColor(lane);
      const place = this.point(motion.points.after, lane);
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

  footCorners(foot, positions, points) {
    return [this.joint(positions, foot.ankle), this.point(points, foot.heel), this.point(points, foot.toe)];
  }

  sideColor(lane) {
    return sideColor(this.theme, this.contacts.effectors[lane]);
  }
}

// What lies on the floor of the stage: its squares, the footprints, the plant that is looked at, the shadow.

/** Floor squares that grow with the distance, fading out away from the target. */
function drawGrid(stage) {
  const { camera, context, theme, motion } = stage;
  stage.square = roundStep(camera.distance * 0.11);
  const reach = 14;
  const cx = Math.round((camera.target[0] + camera.pan[0]) / stage.square);
  const cz = Math.round((camera.target[2] + camera.pan[2]) / stage.square);
  const { floor } = motion;
  context.strokeStyle = theme.line;
  context.lineWidth = 1;
  const layers = [[], [], [], []];
  for (let a = -reach; a <= reach; a++) {
    for (let b = -reach; b < reach; b++) {
      const away = Math.hypot(a, b + 0.5) / reach;
      if (away >= 1) continue;
      const layer = layers[Math.floor(away * 4)];
      const [u, v, w] = [a * stage.square, b * stage.square, (b + 1) * stage.square];
      const [ox, oz] = [cx * stage.square, cz * stage.square];
      layer.push([[ox + u, floor, oz + v], [ox + u, floor, oz + w]]);
      layer.push([[ox + v, floor, oz + u], [ox + w, floor, oz + u]]);
    }
  }
  layers.forEach((segments, k) => {
    context.beginPath();
    for (const [a, b] of segments) {
      const line = camera.segment(a, b);
      if (!line) continue;
      context.moveTo(line[0][0], line[0][1]);
      context.lineTo(line[1][0], line[1][1]);
    }
    context.globalAlpha = [1, 0.75, 0.45, 0.2][k];
    context.stroke();
  });
  context.globalAlpha = 1;
}

/** Where each foot stands: the way of its toe joint or ankle over the floor, of the figures that are shown. */
function drawPrints(stage, when, ghost) {
  const { motion, player, theme, seen } = stage;
  const near = 4 / motion.frameTime;
  const thick = Math.max(1.5, Math.min(4, stage.camera.focal * motion.size.height * 0.004 / stage.camera.distance));
  stage.contacts.lanes.forEach((lane, k) => {
    if (k >= motion.soles.length) return;
    for (const contact of lane) {
      if (wishOf(contact) === "forbid") continue;
      const away = Math.max(contact.start - player.frame, player.frame - contact.end, 0);
      if (away > near) continue;
      const alpha = away === 0 ? 1 : 0.55 * (1 - away / near) + 0.1;
      const color = when === "before" ? theme.was : stage.sideColor(k);
      if (ghost) stage.trace(seen.way("before", k, contact, player.index), theme.was, thick, { alpha });
      const way = seen.way(when, k, contact, player.index);
      stage.trace(way, color, thick, { alpha });
      stage.context.globalAlpha = alpha;
      stage.dot(middlePlace(way), thick * 1.7, color, theme.stage);
      stage.context.globalAlpha = 1;
    }
  });
}

/** The plant that is looked at: its way before and after, and around its place how far viewers let it slide. */
function drawChosen(stage, when, ghost) {
  const { selection } = stage.contacts;
  if (!selection || selection.lane >= stage.motion.soles.length) return;
  const { lane, contact } = selection;
  const way = stage.seen.way(when, lane, contact, stage.player.index);
  const [x, y, z] = middlePlace(way);
  const ring = Array.from({ length: 49 }, (_, k) => {
    const turn = (k / 48) * 2 * Math.PI;
    return [x + NOTICED * Math.cos(turn), y, z + NOTICED * Math.sin(turn)];
  });
  stage.trace(ring, stage.theme.ink, 1.2, { dash: [3, 3] });
  if (ghost) stage.trace(stage.seen.way("before", lane, contact, stage.player.index), stage.theme.was, 3);
  stage.trace(way, when === "before" ? stage.theme.was : stage.sideColor(lane), 3);
}

function drawShadow(stage, when) {
  const { motion, context, camera } = stage;
  context.beginPath();
  for (const [a, b] of motion.bones) {
    const [p, q] = [stage.joint(motion.joints[when], a), stage.joint(motion.joints[when], b)];
    const line = camera.segment([p[0], motion.floor, p[2]], [q[0], motion.floor, q[2]]);
    if (!line) continue;
    context.moveTo(line[0][0], line[0][1]);
    context.lineTo(line[1][0], line[1][1]);
  }
  context.lineWidth = Math.max(3, Math.min(18, (camera.focal * motion.size.height * 0.03) / camera.distance));
  context.strokeStyle = stage.theme.shadow;
  context.stroke();
}

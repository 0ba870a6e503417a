// Contact bars: filled as far as the contact is certain; a forced one with a pin, a forbidden one hatched.

function drawBar(context, theme, box, contact, color, chosen) {
  const { x, y, wide, tall } = box;
  const wish = wishOf(contact);
  const outline = new Path2D();
  outline.roundRect(x, y, wide, tall, Math.min(3, wide / 2));
  context.save();
  context.clip(outline);
  context.fillStyle = color;
  context.globalAlpha = wish === "forbid" ? 0.08 : 0.25;
  context.fill(outline);
  context.globalAlpha = 1;
  if (wish === "forbid") hatch(context, color, box);
  else {
    const sure = tall * Math.max(0, Math.min(1, contact.confidence ?? 1));
    context.fillRect(x, y + tall - sure, wide, sure);
  }
  context.restore();
  context.lineWidth = chosen ? 2.5 : 1;
  context.strokeStyle = chosen ? theme.ink : color;
  context.stroke(outline);
  if (wish === "force") drawPin(context, theme, x + wide / 2, y + tall / 2);
}

function hatch(context, color, { x, y, wide, tall }) {
  context.beginPath();
  for (let k = -tall; k < wide; k += 6) {
    context.moveTo(x + k, y + tall);
    context.lineTo(x + k + tall, y);
  }
  context.strokeStyle = color;
  context.lineWidth = 1.2;
  context.stroke();
}

function drawPin(context, theme, x, y) {
  context.save();
  context.translate(x, y);
  context.rotate(Math.PI / 4);
  context.fillStyle = theme.stage;
  context.fillRect(-3.5, -3.5, 7, 7);
  context.restore();
}

/** A bar whose plant still slides farther than viewers let pass. */
function underline(context, theme, { x, y, wide, tall }) {
  context.fillStyle = theme.fair;
  context.fillRect(x, y + tall + 1.5, wide, 3);
}

/** What a pointer takes hold of at the end of the bar that is chosen. */
function drawHandle(context, theme, x, { y, tall }) {
  context.beginPath();
  context.roundRect(x - 3, y - 2, 6, tall + 4, 3);
  context.fillStyle = theme.ink;
  context.fill();
}

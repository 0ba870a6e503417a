// What all canvases share: sharp pixels, pictures that are kept, round numbers, the colours of the legs.

const NOTICED = 0.021; // a slide that viewers notice [m]

/** A canvas made as sharp as the screen; sizes are in CSS pixels. */
function fit(canvas) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const ratio = Math.min(window.devicePixelRatio || 1, 3);
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}

/** A picture that changes seldom: painted once, then copied, until it is stale or the canvas changes its size. */
class Still {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.stale = true;
  }

  /** Puts the picture on a canvas that `fit` has readied; `paint(context)` draws in CSS pixels. */
  show(context, paint) {
    const target = context.canvas;
    const [width, height] = [target.clientWidth, target.clientHeight];
    if (this.stale || this.canvas.width !== target.width || this.canvas.height !== target.height) {
      this.canvas.width = target.width;
      this.canvas.height = target.height;
      const still = this.canvas.getContext("2d");
      still.setTransform(context.getTransform());
      paint(still);
      this.stale = false;
    }
    context.clearRect(0, 0, width, height);
    if (this.canvas.width && this.canvas.height) context.drawImage(this.canvas, 0, 0, width, height);
  }
}

/** The largest of 1, 2, 5 x 10^n that is not above a value. */
function roundStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((digit) => digit * power <= value) * power;
}

/** The colour of the leg that an effector belongs to. */
function sideColor(theme, effector) {
  return effector && /right/i.test(`${effector.side} ${effector.name}`) ? theme.right : theme.left;
}

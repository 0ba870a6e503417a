// Pointers and keys on the stage: drag to turn, Shift or another button to move, wheel or two fingers to zoom.

class Orbit {
  constructor(stage, refresh) {
    Object.assign(this, { stage, canvas: stage.canvas, camera: stage.camera, held: new Map() });
    const on = (type, handler, options) => this.canvas.addEventListener(type, (event) => {
      handler.call(this, event);
      refresh();
    }, options);
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.up);
    on("wheel", this.wheel, { passive: false });
    on("dblclick", () => stage.frame(null));
    on("contextmenu", (event) => event.preventDefault());
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.held.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  up(event) {
    this.held.delete(event.pointerId);
  }

  /** How far apart two fingers are. */
  spread() {
    const [a, b] = [...this.held.values()];
    return Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1);
  }

  move(event) {
    const from = this.held.get(event.pointerId);
    if (!from) return;
    const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
    const spread = this.held.size === 2 ? this.spread() : 0;
    this.held.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (spread) {
      this.camera.zoom(spread / this.spread());
      this.camera.drag(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) this.camera.drag(dx, dy);
    else this.camera.orbit(-dx * 0.008, dy * 0.008);
  }

  /** Until the stage has been clicked, the wheel scrolls the page as everywhere else. */
  wheel(event) {
    if (document.activeElement !== this.canvas && !event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    this.camera.zoom(1.0012 ** event.deltaY);
  }

  /** Arrows turn, with Shift they move, plus and minus zoom; false for any other key. */
  key(event) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.key in arrows) {
      const [x, y] = arrows[event.key];
      if (event.shiftKey) this.camera.drag(-x * 24, -y * 24);
      else this.camera.orbit(x * 0.12, -y * 0.12);
    } else if (event.key === "+" || event.key === "=") this.camera.zoom(0.88);
    else if (event.key === "-") this.camera.zoom(1.14);
    else return false;
    return true;
  }
}

// Time: which frame is shown, whether it runs, and over which stretch it loops.

class Player {
  constructor(motion) {
    this.motion = motion;
    this.index = 0; // of the shown frames
    this.playing = false;
    this.speed = 1;
    this.loop = null; // {from, to} in frames of the clip
    this.listeners = new Set();
    this.clock = 0; // when the last frame was counted [ms]
    this.rest = 0; // of a frame, that has passed already
    this.rounds = 0; // of a loop, that have been played
  }

  /** The frame of the clip that is shown. */
  get frame() {
    return this.index * this.motion.step;
  }

  get seconds() {
    return this.frame * this.motion.frameTime;
  }

  /** The shown frames that playing runs over, both included. */
  get range() {
    const { shown, round } = this.motion;
    const last = shown - (round?.closed && !this.loop ? 2 : 1);
    if (!this.loop) return [0, last];
    const from = Math.min(last, Math.max(0, Math.floor(this.loop.from / this.motion.step)));
    return [from, Math.max(from, Math.min(last, Math.ceil(this.loop.to / this.motion.step)))];
  }

  changed() {
    for (const listener of this.listeners) listener();
  }

  /** Goes to the shown frame nearest to a frame of the clip. */
  seek(frame) {
    const index = Math.round(frame / this.motion.step);
    this.index = Math.max(0, Math.min(this.motion.shown - 1, index));
    this.rest = this.rounds = 0;
    this.changed();
  }

  stepBy(shownFrames) {
    this.pause();
    this.seek((this.index + shownFrames) * this.motion.step);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.playing || this.motion.shown < 2) return;
    this.playing = true;
    this.rest = 0;
    this.clock = performance.now();
    const [from, to] = this.range;
    if (this.index < from || this.index >= to) this.index = from;
    requestAnimationFrame((now) => this.tick(now));
    this.changed();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.changed();
  }

  /** Loops over frames of the clip; null for all of it. */
  loopOver(stretch) {
    this.loop = stretch;
    this.rounds = 0;
    const [from, to] = this.range;
    if (this.index < from || this.index > to) this.index = from;
    this.changed();
  }

  tick(now) {
    if (!this.playing) return;
    // A tab that slept must not leap: at most a quarter of a second passes at once.
    const passed = Math.min(Math.max(now - this.clock, 0) / 1000, 0.25);
    this.clock = now;
    this.rest += (passed * this.speed) / (this.motion.frameTime * this.motion.step);
    const whole = Math.floor(this.rest);
    if (whole > 0) {
      this.rest -= whole;
      const [from, to] = this.range;
      const length = to - from + 1;
      const ahead = this.index - from + whole;
      this.index = from + (ahead % length);
      if (this.motion.round && !this.loop) this.rounds += Math.floor(ahead / length);
      this.changed();
    }
    requestAnimationFrame((next) => this.tick(next));
  }
}

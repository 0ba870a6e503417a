// The page's start: reads the data, builds the parts and ties them to one player.

const element = (id) => document.getElementById(id);

/** The colours and fonts of the style sheet, for the canvases. */
function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const value = (name) => style.getPropertyValue(`--${name}`).trim();
  const family = getComputedStyle(document.body).fontFamily;
  const theme = { small: `11px ${family}`, strong: `600 12px ${family}` };
  const names = ["ink", "muted", "line", "axis", "stage", "left", "right", "was", "bone", "shadow", "fair"];
  for (const name of names) theme[name] = value(name);
  return theme;
}

class Viewer {
  constructor(data) {
    this.motion = readMotion(data.motion);
    this.player = new Player(this.motion);
    this.contacts = new Contacts(data.contacts, this.motion.frames, data.plants);
    this.stage = new Stage(element("stage"), this.motion, this.player, this.contacts);
    this.timeline = new Timeline(element("timeline"), this.motion, this.player, this.contacts);
    this.parts = [this.stage, this.timeline];
    this.parts.push(new PathMap(element("paths"), this.motion, this.player, this.contacts));
    const drift = new DriftPlot(element("drift"), this.motion, this.player);
    if (drift.moves) this.parts.push(drift);
    else {
      element("unmoved").hidden = false;
      element("unmoved").nextElementSibling.hidden = element("drift").hidden = true;
    }
    this.table = new PlantsTable(element("plants"), (plant) => this.showPlant(plant));
    this.editor = new Editor(element("editor"), this.timeline, (words) => this.say(words));
    new TimelineInput(this.timeline);
    this.orbit = new Orbit(this.stage, () => this.refresh());
    this.theme = readTheme();
    this.pending = false;
    this.player.listeners.add(() => this.refresh());
    this.contacts.listeners.add(() => this.refresh());
    this.wireControls();
    wireKeys(this);
    this.wireLooks();
    openPage(this);
    addEventListener("hashchange", () => {
      this.player.pause();
      openPage(this);
    });
    this.refresh();
  }

  /** Draws everything once before the next picture of the screen. */
  refresh() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  draw() {
    for (const part of this.parts) part.draw(this.theme);
    const { player, timeline, motion } = this;
    const [seconds, frame] = [player.seconds.toFixed(2), player.frame];
    element("time").textContent = `${seconds} s · frame ${frame} of ${motion.frames}`;
    element("time").href = `#f=${frame}`;
    element("scrub").value = String(player.index);
    element("scrub").setAttribute("aria-valuetext", `frame ${frame}, ${seconds} seconds`);
    const play = element("play");
    play.setAttribute("aria-label", player.playing ? "Pause" : "Play");
    play.dataset.playing = String(player.playing);
    element("loop").setAttribute("aria-pressed", String(player.loop !== null));
    const at = timeline.hover || { frame: player.frame, lane: null };
    element("readout").textContent = describe(timeline, at.frame, at.lane, at.knees) + (timeline.hover ? "" : this.plantedNow());
    element("square").textContent = `Floor squares: ${metres(this.stage.square)}`;
  }

  plantedNow() {
    const { contacts, player } = this;
    const planted = contacts.effectors.filter((_, lane) => contacts.planted(lane, player.frame));
    return planted.length ? `: planted ${planted.map(named).join(", ")}` : ": no contact";
  }

  say(words) {
    element("live").textContent = words;
  }

  // ---- controls ------------------------------------------------------------------------------------

  wireControls() {
    const { player, timeline } = this;
    const act = (id, handler) => element(id).addEventListener("click", handler);
    element("scrub").max = String(this.motion.shown - 1);
    element("scrub").addEventListener("input", (event) => {
      player.pause();
      player.seek(Number(event.target.value) * this.motion.step);
    });
    element("speed").addEventListener("change", (event) => {
      player.speed = Number(event.target.value);
    });
    act("play", () => player.toggle());
    act("back", () => player.stepBy(-1));
    act("forth", () => player.stepBy(1));
    act("loop", () => this.toggleLoop());
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => this.look(button.dataset.view));
    }
    for (const button of document.querySelectorAll("[data-show]")) {
      button.addEventListener("click", () => this.toggle(button.dataset.show));
    }
    for (const button of document.querySelectorAll("[data-figures]")) {
      button.addEventListener("click", () => this.showFigures(button.dataset.figures));
    }
    act("whole", () => this.wholeFigure());
    act("zoom-in", () => this.zoomTimeline(0.5));
    act("zoom-out", () => this.zoomTimeline(2));
    act("zoom-all", () => this.zoomTimeline(Infinity));
    act("range", (event) => {
      timeline.whole = this.press(event.currentTarget, !timeline.whole);
      timeline.still.stale = true;
      this.refresh();
    });
    act("edit", () => this.toggleEditing());
  }

  press(button, pressed) {
    button.setAttribute("aria-pressed", String(pressed));
    return pressed;
  }

  toggle(name) {
    const { show } = this.stage;
    show[name] = this.press(document.querySelector(`[data-show="${name}"]`), !show[name]);
    this.refresh();
  }

  /** Shows the figure "before", "after", "both" in one place, or both "beside" each other. */
  showFigures(which) {
    this.stage.figures = which;
    for (const button of document.querySelectorAll("[data-figures]")) {
      this.press(button, button.dataset.figures === which);
    }
    this.refresh();
  }

  look(name) {
    this.stage.view(name);
    this.refresh();
  }

  wholeFigure() {
    this.stage.frame(null);
    this.refresh();
  }

  toggleLoop() {
    if (this.player.loop) {
      this.player.loopOver(null);
      this.table.clear();
    } else {
      const [from, to] = this.timeline.window;
      this.player.loopOver({ from, to });
    }
  }

  zoomTimeline(factor) {
    if (factor === Infinity) this.timeline.zoomTo(0, this.motion.frames);
    else this.timeline.zoom(factor);
    this.refresh();
  }

  toggleEditing() {
    const { timeline } = this;
    timeline.editing = this.press(element("edit"), !timeline.editing);
    element("editor").hidden = !timeline.editing;
    timeline.still.stale = true;
    this.refresh();
  }

  /** Makes a plant the one that is looked at; gives its lane, -1 where it has none. */
  choose({ effector, start }) {
    const lane = this.contacts.effectors.findIndex((each) => each.name === effector);
    if (lane < 0 || lane >= this.motion.soles.length) return -1;
    this.contacts.select(lane, this.contacts.lanes[lane].find((each) => each.start === start) || null);
    return lane;
  }

  /** Jumps to a plant, looks at its leg from close by and loops over it with a little before and after. */
  showPlant(plant) {
    const { motion, player, timeline, stage } = this;
    const { effector, start, end } = plant;
    const second = 1 / motion.frameTime;
    const around = Math.min(Math.max(0.15 * second, 0.25 * (end - start)), 0.5 * second);
    const lane = this.choose(plant);
    if (lane >= 0) stage.frame(stage.legBall(lane, start - 0.1 * second, end + 0.1 * second));
    timeline.zoomTo(start - 3 * around, end + 3 * around);
    player.loopOver({ from: start - around, to: end + around });
    player.seek(start);
    player.play();
    this.say(`${effector.replaceAll("_", " ")}, frames ${start} to ${end}, playing in a loop`);
  }

  /** Everything is painted anew at the next drawing. */
  renew() {
    for (const { still } of this.parts) if (still) still.stale = true;
  }

  // ---- looks -----------------------------------------------------------------------------------------

  wireLooks() {
    const restyle = () => {
      this.theme = readTheme();
      this.renew();
      this.refresh();
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
    new ResizeObserver(restyle).observe(document.body);
    const print = (on) => () => {
      document.documentElement.classList.toggle("print", on);
      this.theme = readTheme();
      this.renew();
      this.draw();
    };
    addEventListener("beforeprint", print(true));
    addEventListener("afterprint", print(false));
    addEventListener("beforeunload", (event) => {
      if (this.editor.unsaved) event.preventDefault();
    });
  }
}

function metres(value) {
  return value >= 1 ? `${value} m` : `${+(value * 100).toPrecision(2)} cm`;
}

document.documentElement.classList.add("live");
new Viewer(JSON.parse(element("data").textContent));

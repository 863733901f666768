// The time that all parts of the page show, and playing it.

const clock = {
  t: 0, // [s]
  end: 0,
  playing: false,
  frame: 0, // of the motion that plays
  speed: 1, // seconds of the run in a second
  listeners: [],

  onChange(tell) {
    this.listeners.push(tell);
  },
  set(t) {
    this.t = Math.min(Math.max(t, 0), this.end);
    for (const tell of this.listeners) tell(this.t);
  },
  toggle() {
    this.playing = !this.playing;
    cancelAnimationFrame(this.frame); // of a motion that ended within this frame
    if (this.playing) {
      if (this.t >= this.end) this.t = 0;
      let before = performance.now();
      const step = (now) => {
        if (!this.playing) return;
        // A page that was hidden goes on where it was.
        const t = this.t + (Math.min(now - before, 1000) / 1000) * this.speed;
        before = now;
        if (t >= this.end) this.playing = false;
        this.set(t);
        if (this.playing) this.frame = requestAnimationFrame(step);
      };
      this.frame = requestAnimationFrame(step);
    }
    this.set(this.t);
  },
  // The speed nearest to real time at which the whole run takes 2 to 20 s.
  fitSpeed(speeds) {
    const fit = speeds.filter((speed) => this.end >= 2 * speed && this.end <= 20 * speed);
    const near = (speed) => Math.abs(Math.log(speed));
    this.speed = fit.sort((a, b) => near(a) - near(b))[0] ?? (this.end > speeds.at(-1) ? speeds.at(-1) : speeds[0]);
  },
};

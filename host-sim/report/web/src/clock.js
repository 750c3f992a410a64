// The one time of the page: what it is, whether it runs, how fast, and who wants to know.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];

export class Clock {
  #listeners = [];
  #last = 0;
  t = 0;
  speed = 1;
  playing = false;

  constructor(end, step) {
    this.end = end;
    this.step = step;
  }

  listen(listener) {
    this.#listeners.push(listener);
  }

  set(t) {
    this.t = Math.max(0, Math.min(this.end, t));
    this.#tell();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.#tell();
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.t >= this.end) this.t = 0;
    this.#last = performance.now();
    if (this.playing) requestAnimationFrame(this.#frame);
    this.#tell();
  }

  #frame = (now) => {
    if (!this.playing) return;
    const passed = Math.max(0, now - this.#last) / 1000;
    this.#last = now;
    this.t = Math.min(this.end, this.t + passed * this.speed);
    this.playing = this.t < this.end;
    this.#tell();
    if (this.playing) requestAnimationFrame(this.#frame);
  };

  #tell() {
    for (const listener of this.#listeners) listener(this);
  }
}

// The stage of the arms: light, floor, camera, arrows. It draws when something has changed, not all the time.

import {
  ArrowHelper, Box3, Color, DirectionalLight, GridHelper, HemisphereLight, PerspectiveCamera, Scene, Sphere, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Arm } from './arm.js';
import { isOver, rowAt } from './columns.js';
import { colour, onTheme } from './dom.js';

/** Field of view from top to bottom, degrees. */
const FIELD = 34;
const VIEWS = [[1.1, -1.35, 0.75], [0.01, -1.9, 0.25], [1.9, -0.01, 0.25], [0.01, -0.02, 2.0]];

/** An arrow that is hidden where its vector is shorter than `least`. */
function arrow(colourName) {
  const made = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 1);
  made.userData.colour = colourName;
  made.visible = false;
  for (const part of [made.line, made.cone]) {
    part.material.depthTest = false;
    part.renderOrder = 2;
  }
  return made;
}

function point(arrowTo, from, vector, length) {
  const size = vector.length();
  arrowTo.visible = size > 0 && length > 0;
  if (!arrowTo.visible) return;
  arrowTo.position.copy(from);
  arrowTo.setDirection(vector.clone().divideScalar(size));
  arrowTo.setLength(length, Math.min(0.3 * length, 0.08 * arrowTo.userData.size), 0.05 * arrowTo.userData.size);
}

export class Stage {
  /** For a browser with WebGL. */
  constructor(host, runs) {
    this.host = host;
    this.runs = runs;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    host.append(this.renderer.domElement);
    const canvas = this.renderer.domElement;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `The arm of ${runs[0].robot}, drawn from its joints; drag turns it, the wheel zooms`);
    this.scene = new Scene();
    this.arms = runs.map((run, index) => new Arm(run, index > 0));
    this.size = Math.max(...this.arms.map((arm) => arm.size));
    for (const arm of this.arms) this.scene.add(arm.group, ...arm.paths);
    this.light = new HemisphereLight(0xffffff, 0x667788, 2.2);
    this.light.position.set(0, 0, 1);
    const sun = new DirectionalLight(0xffffff, 1.8);
    sun.position.set(1, -1.4, 2);
    this.scene.add(this.light, sun);
    this.#camera(canvas);
    this.#arrows();
    this.paint();
    onTheme(() => this.paint());
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  #arrows() {
    this.arrows = { gravity: arrow('gravity'), contact: arrow('contact'), estimate: arrow('estimate') };
    for (const made of Object.values(this.arrows)) {
      made.userData.size = this.size;
      this.scene.add(made);
    }
    const g = new Vector3(...this.runs[0].gravity);
    // Inside the ball that every view shows whole, beside what stands in its middle.
    const { center, radius } = this.ball;
    const beside = new Vector3(-0.72, -0.2, 0.55).multiplyScalar(radius).add(center);
    point(this.arrows.gravity, beside, g, g.length() > 0 ? 0.4 * radius : 0);
    // Forces in scale with the greatest that is known; with the greatest estimate, where none is.
    const { wrenches, wrench, rows } = this.runs[0];
    this.newtons = Math.max(0, ...wrenches.map(({ force }) => Math.hypot(...force)));
    for (let row = 0; wrench && !wrenches.length && row < rows; row += 1) {
      this.newtons = Math.max(this.newtons, Math.hypot(wrench[0][row], wrench[1][row], wrench[2][row]) || 0);
    }
  }

  #camera(canvas) {
    this.camera = new PerspectiveCamera(FIELD, 1, 0.01 * this.size, 40 * this.size);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.view = -1;
    // About everything that any joint has passed.
    const passed = new Box3().setFromPoints([new Vector3()]);
    for (const arm of this.arms) {
      const every = Math.max(1, Math.floor(arm.run.rows / 50));
      for (let row = 0; row < arm.run.rows; row += every) {
        arm.pose(row);
        for (const at of arm.jointsAt()) passed.expandByPoint(at);
      }
    }
    this.ball = passed.getBoundingSphere(new Sphere());
    this.controls.target.copy(this.ball.center);
    this.away = (1.12 * (this.ball.radius + 0.06 * this.size)) / Math.sin((0.5 * FIELD * Math.PI) / 180);
    this.controls.addEventListener('change', () => this.draw());
    this.nextView();
  }

  nextView() {
    this.view = (this.view + 1) % VIEWS.length;
    const away = new Vector3(...VIEWS[this.view]).setLength(this.away);
    this.camera.position.copy(this.controls.target).add(away);
    this.controls.update();
    this.draw();
  }

  /** Take the colours of the style sheet. */
  paint() {
    const of = (name) => new Color(colour(name));
    this.arms.forEach((arm, index) => {
      arm.links.color = of(index ? 'ghost' : 'link');
      arm.joints.color = of(index ? 'ghost' : 'joint');
      arm.load.color = of('payload');
      arm.whole.material.color = of('faint');
      arm.gone.material.color = of(index ? 'c1' : 'c0');
    });
    for (const made of Object.values(this.arrows)) made.setColor(of(made.userData.colour));
    if (this.grid) this.scene.remove(this.grid);
    const decade = 10 ** Math.floor(Math.log10(this.size / 4));
    const step = [1, 2, 5].map((x) => x * decade).filter((x) => x <= this.size / 4).pop();
    const cells = 2 * Math.ceil((0.8 * this.size) / step);
    this.grid = new GridHelper(cells * step, cells, of('grid'), of('grid'));
    this.grid.rotation.x = Math.PI / 2;
    this.scene.add(this.grid);
    // At once: before paper there is no next frame.
    this.renderer.render(this.scene, this.camera);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    // In a narrow view, as much from side to side as otherwise from top to bottom.
    this.camera.fov = width < height ? Math.min(70, (FIELD * height) / width) : FIELD;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Show the arms at `t` (s). */
  show(t) {
    this.arms.forEach((arm, index) => {
      arm.pose(rowAt(this.runs[index], t));
      arm.fade(isOver(this.runs[index], t));
    });
    const [run] = this.runs;
    const [arm] = this.arms;
    const tip = arm.tipAt();
    const told = new Vector3();
    for (const wrench of run.wrenches) {
      if (t >= wrench.from && t < wrench.to) told.add(new Vector3(...wrench.force));
    }
    // A wrench that is told is in tip axes; one that is estimated, in base axes.
    const size = told.length();
    told.transformDirection(arm.tip.matrixWorld).multiplyScalar(size);
    const length = (size) => (this.newtons > 0 ? this.size * Math.min((0.3 * size) / this.newtons, 0.5) : 0);
    point(this.arrows.contact, tip, told, length(size));
    // Behind a fault nobody estimates.
    const guess = run.wrench && arm.row < run.driven ? new Vector3(...[0, 1, 2].map((axis) => run.wrench[axis][arm.row] || 0)) : new Vector3();
    point(this.arrows.estimate, tip, guess, length(guess.length()));
    this.draw();
  }

  showFrames(visible) {
    for (const arm of this.arms) arm.showFrames(visible);
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}

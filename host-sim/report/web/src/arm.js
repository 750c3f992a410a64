// The arm in three dimensions, from its joints' frames and positions.
//
// `parent_from_link = place * (turn about z, or slide along z)`: the same transforms as the controller's model. Every link is a group in
// the group of the link before it, so that three multiplies the chain out.

import {
  AxesHelper, BufferAttribute, BufferGeometry, CapsuleGeometry, CylinderGeometry, Group, Line, LineBasicMaterial, LineDashedMaterial,
  Matrix4, Mesh, MeshStandardMaterial, SphereGeometry, Vector3,
} from 'three';

const UP = new Vector3(0, 1, 0);

function matrix(place) {
  return new Matrix4().set(...place, 0, 0, 0, 1);
}

function origin(place) {
  return new Vector3(place[3], place[7], place[11]);
}

/** A capsule from the origin to `to`; nothing for a point. */
function bone(to, radius, material) {
  const length = to.length();
  if (length < 1e-6) return new Group();
  const mesh = new Mesh(new CapsuleGeometry(radius, length, 6, 16), material);
  mesh.position.copy(to).multiplyScalar(0.5);
  mesh.quaternion.setFromUnitVectors(UP, to.clone().normalize());
  return mesh;
}

/** A cylinder along z, about the origin. */
function barrel(radius, length, material) {
  const mesh = new Mesh(new CylinderGeometry(radius, radius, length, 28), material);
  mesh.rotation.x = Math.PI / 2;
  return mesh;
}

/** How far the arm can reach at most, m. */
export function reach(run) {
  const lengths = [...run.chain.map((joint) => origin(joint.place).length()), origin(run.tip).length()];
  const slides = run.chain.map((joint, i) => (joint.slides ? Math.max(...run.columns.q[i].at.map(Math.abs)) : 0));
  return Math.max([...lengths, ...slides].reduce((sum, x) => sum + x, 0), 0.05);
}

export class Arm {
  constructor(run, ghost) {
    this.run = run;
    this.group = new Group();
    this.size = reach(run);
    this.opacity = ghost ? 0.4 : 1;
    const solid = { roughness: 0.55, metalness: 0.1, transparent: ghost, opacity: this.opacity, depthWrite: !ghost };
    this.links = new MeshStandardMaterial(solid);
    this.joints = new MeshStandardMaterial(solid);
    this.load = new MeshStandardMaterial(solid);
    this.frames = [];
    this.#build(ghost);
    this.#trace(ghost);
  }

  #build(ghost) {
    const { run, size } = this;
    const count = run.chain.length;
    let parent = this.group;
    this.moving = run.chain.map((joint, i) => {
      const radius = size * 0.034 * (1 - (0.55 * i) / Math.max(count, 2));
      const fixed = new Group();
      fixed.matrixAutoUpdate = false;
      fixed.matrix.copy(matrix(joint.place));
      parent.add(fixed);
      const link = new Group();
      fixed.add(link);
      // A slide is drawn from where it is at zero to where it is.
      const rod = joint.slides ? barrel(radius * 0.6, 1, this.joints) : undefined;
      if (rod) fixed.add(rod);
      if (!joint.slides) link.add(barrel(radius * 1.25, radius * 2.6, this.joints));
      const to = origin(i + 1 < count ? run.chain[i + 1].place : run.tip);
      link.add(bone(to, radius * 0.8, this.links));
      if (!ghost) this.#frame(link, size * 0.09);
      parent = link;
      return { link, rod, slides: joint.slides };
    });
    this.tip = new Group();
    this.tip.matrixAutoUpdate = false;
    this.tip.matrix.copy(matrix(run.tip));
    parent.add(this.tip);
    if (!ghost) this.#frame(this.tip, size * 0.09);
    if (run.payload) this.#payload(run.payload);
  }

  #frame(parent, length) {
    const axes = new AxesHelper(length);
    axes.visible = false;
    parent.add(axes);
    this.frames.push(axes);
  }

  /** A ball of steel of its mass, at its mass centre. */
  #payload({ mass, com }) {
    const radius = Math.max(Math.cbrt((3 * mass) / (4 * Math.PI * 7850)), 0.015 * this.size);
    const ball = new Mesh(new SphereGeometry(radius, 24, 16), this.load);
    ball.position.set(...com);
    this.tip.add(ball);
  }

  /** The way of the tip over all rows: thin in whole, thick as far as it has come. */
  #trace(ghost) {
    const points = new Float32Array(3 * this.run.rows);
    for (let row = 0; row < this.run.rows; row += 1) {
      this.pose(row);
      points.set(this.tipAt().toArray(), 3 * row);
    }
    const geometry = () => {
      const made = new BufferGeometry();
      made.setAttribute('position', new BufferAttribute(points, 3));
      return made;
    };
    this.whole = new Line(geometry(), new LineDashedMaterial({ dashSize: 0.012 * this.size, gapSize: 0.012 * this.size }));
    this.whole.computeLineDistances();
    this.gone = new Line(geometry(), new LineBasicMaterial());
    for (const line of [this.whole, this.gone]) line.frustumCulled = false;
    this.paths = ghost ? [this.gone] : [this.whole, this.gone];
  }

  /** Take the positions of a row. */
  pose(row) {
    this.row = row;
    this.moving.forEach(({ link, rod, slides }, i) => {
      const q = this.run.columns.q[i].at[row];
      if (slides) link.position.z = q;
      else link.rotation.z = q;
      if (rod) {
        rod.scale.y = Math.max(Math.abs(q), 1e-6);
        rod.position.z = q / 2;
      }
    });
    this.group.updateMatrixWorld(true);
    this.gone?.geometry.setDrawRange(0, row + 1);
  }

  /** Draw the arm faintly, once its run is over, or as it is. */
  fade(faint) {
    if (this.faint === faint) return;
    this.faint = faint;
    for (const material of [this.links, this.joints, this.load]) {
      material.opacity = faint ? 0.25 * this.opacity : this.opacity;
      material.transparent = material.opacity < 1;
      material.depthWrite = !material.transparent;
      // Transparent or not is compiled into a program.
      material.needsUpdate = true;
    }
  }

  /** Origin of the tip in the base frame, m. */
  tipAt() {
    return new Vector3().setFromMatrixPosition(this.tip.matrixWorld);
  }

  /** Origins of the joints and the tip in the base frame, m. */
  jointsAt() {
    return [...this.moving.map(({ link }) => link), this.tip].map((frame) => new Vector3().setFromMatrixPosition(frame.matrixWorld));
  }

  showFrames(visible) {
    for (const axes of this.frames) axes.visible = visible;
  }
}

// A session while it runs: the arm, each joint's numbers, the state in words, and a stop button. The page holds, as JSON under the id `live-data`,
//
// { robot, joints: [{ name, position_unit, torque_unit }], chain: [{ slides, place }], tip, gravity, payload }     as for runs.js
//
// and gets the state from `state`, an event stream of the server that it came from (host-sim/board/src/session/local/snapshot.rs).

import { element } from './dom.js';
import { Stage } from './scene.js';

/** Without a message for so long, what the page shows is old, ms. The server sends one every second at least. */
const SILENCE = 2500;
/** A state of this age is old, s: the session sends one fifty times a second. */
const OLD = 0.5;

/** The arm as a run of one row, whose positions change. */
function asRun(data) {
  const q = data.joints.map(() => ({ at: new Float32Array(1) }));
  return { ...data, rows: 1, wrenches: [], columns: { q } };
}

/** The stage with an arm in any posture, or undefined without WebGL. */
function stage(box, run) {
  // Asked first: three would complain on the console.
  if (!document.createElement('canvas').getContext('webgl2')) {
    box.classList.add('flat');
    box.append(element('p', {}, 'This browser draws no WebGL: the arm is not shown. The table is complete.'));
    return undefined;
  }
  const made = new Stage(box, [run]);
  for (const path of made.arms[0].paths) path.visible = false;
  made.away = 3.4 * made.size;
  made.controls.target.set(0, 0, 0.3 * made.size);
  made.view = -1;
  made.nextView();
  return made;
}

const shown = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits) : '-');

export function showSession(host, data) {
  const run = asRun(data);
  const state = element('p', { class: 'state', role: 'status', 'aria-live': 'polite' }, 'connecting');
  const timing = element('p', { class: 'marks' });
  const answer = element('p', { class: 'warns', role: 'alert' });
  const button = element('button', { type: 'button', class: 'halt', title: 'Esc' }, 'Stop');
  const scene = element('div', { class: 'scene' });
  const cells = data.joints.map(() => [1, 2, 3].map(() => element('td', {}, '-')));
  const rows = data.joints.map((joint, i) => element('tr', {}, element('th', { scope: 'row' }, joint.name), ...cells[i]));
  const heads = ['joint', 'position', 'torque', 'heat of the motor'].map((name) => element('th', { scope: 'col' }, name));
  host.replaceChildren(
    element('div', { class: 'stage' }, scene),
    element('div', { class: 'panel' }, button, answer, state,
      element('div', { class: 'table' }, element('table', {}, element('thead', {}, element('tr', {}, ...heads)), element('tbody', {}, ...rows))),
      timing),
  );
  const arm = stage(scene, run);

  /** Ask for a stop. Only the session's own message says that the arm has stopped. */
  async function stop() {
    answer.textContent = 'stop: sent, not confirmed yet';
    try {
      const response = await fetch('stop', { method: 'POST', signal: AbortSignal.timeout(6000) });
      const text = await response.text();
      answer.textContent = response.ok || text.startsWith('NOT CONFIRMED') ? `stop: ${text}` : `stop: NOT CONFIRMED: ${text} Use the emergency stop.`;
    } catch {
      answer.textContent = 'stop: NOT CONFIRMED: no connection. Use the emergency stop.';
    }
  }
  button.addEventListener('click', stop);
  addEventListener('keydown', (event) => {
    if (event.key === 'Escape' && !event.repeat) stop();
  });

  let heard = performance.now();
  function show(told) {
    heard = performance.now();
    const old = told.age > OLD;
    host.classList.toggle('stale', old);
    const words = old ? `NO NEW STATE for ${told.age.toFixed(1)} s; the last one: ${told.text}` : told.text;
    if (state.textContent !== words) state.textContent = words;
    host.dataset.state = told.state;
    host.dataset.tick = told.tick;
    data.joints.forEach((joint, i) => {
      const [position, torque, heat] = cells[i];
      position.textContent = `${shown(told.q[i], 4)} ${joint.position_unit}`;
      torque.textContent = told.torque.length ? `${shown(told.torque[i], 2)} ${joint.torque_unit}` : 'no torque';
      const share = told.heat[i];
      heat.textContent = typeof share === 'number' ? `${Math.floor(100 * share)} %` : 'unknown';
      heat.className = share >= 1 ? 'stop' : share >= 0.8 ? 'caution' : '';
      if (Number.isFinite(told.q[i])) run.columns.q[i].at[0] = told.q[i];
    });
    timing.textContent = told.timing ?? '';
    if (arm) {
      arm.arms[0].pose(0);
      arm.draw();
    }
  }
  const events = new EventSource('state');
  events.onmessage = (event) => show(JSON.parse(event.data));
  setInterval(() => {
    if (performance.now() - heard < SILENCE) return;
    host.classList.add('stale');
    state.textContent = 'NO CONNECTION to the session: what this page shows is old. The arm may move.';
  }, 250);
  host.dataset.ready = 'yes';
  host.dataset.webgl = arm ? 'yes' : 'no';
  // For whoever checks the drawing against the model: origin of the tip in the base frame, m.
  globalThis.tipOfRun = () => arm?.arms[0].tipAt().toArray();
}

// The stack of charts on one time axis, with the marks of events and the line of the clock.

import uPlot from 'uplot';
import { gaps, isOver, rowAt } from './columns.js';
import { colour, element } from './dom.js';
import { engineering, prefix } from './numbers.js';

/** A limit is drawn where it is at most so many times the largest value: beyond, the curve would be flat. */
const LIMIT_RATIO = 4;
const GUTTER = 62;

/** Table of a chart for uPlot: [time, ...curves], and the indices of low and high curves for bands. */
function table(chart, scale) {
  const scaled = (values) => gaps(values).map((x) => (x === null ? null : x / scale));
  const bands = [];
  const series = [{}];
  const tables = [];
  for (const made of chart.curves) {
    const columns = [scaled(made.at)];
    const pen = { ...made.pen, label: made.name, points: { show: false } };
    series.push(pen);
    if (made.low) {
      const hidden = { label: made.name, points: { show: false }, width: 0 };
      bands.push({ series: [series.length + 1, series.length], fill: `${made.pen.stroke}55` });
      series.push(hidden, hidden);
      columns.push(scaled(made.low), scaled(made.high));
    }
    tables.push([Array.from(made.run.time), ...columns]);
  }
  const data = tables.every((one) => one[0].length === tables[0][0].length && one[0][1] === tables[0][0][1])
    ? [tables[0][0], ...tables.flatMap((one) => one.slice(1))]
    : uPlot.join(tables);
  return { data, series, bands };
}

function extent(chart) {
  let [low, high] = [Infinity, -Infinity];
  for (const made of chart.curves) {
    for (const values of [made.at, made.low ?? [], made.high ?? []]) {
      for (const x of values) {
        if (x < low) low = x;
        if (x > high) high = x;
      }
    }
  }
  return low > high ? [-1, 1] : [low, high];
}

export class Charts {
  constructor(host, clock, events) {
    this.host = host;
    this.clock = clock;
    this.events = events;
    this.range = [0, clock.end];
    this.made = [];
    clock.listen(() => this.follow());
    new ResizeObserver(() => this.resize()).observe(host);
  }

  /** Show these charts in place of those before. */
  show(charts) {
    for (const { plot } of this.made) plot.destroy();
    this.host.replaceChildren();
    this.made = charts.map((chart, index) => this.#make(chart, index + 1 === charts.length));
    this.follow();
  }

  #make(chart, last) {
    let [low, high] = extent(chart);
    const most = Math.max(Math.abs(low), Math.abs(high));
    const limits = (chart.limits ?? []).filter((x) => Number.isFinite(x));
    const near = limits.filter((x) => Math.abs(x) <= LIMIT_RATIO * most);
    [low, high] = [Math.min(low, ...near), Math.max(high, ...near)];
    if (chart.zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    const room = Math.max(0.07 * (high - low), 1e-6 * most, 1e-12);
    const [scale, letter] = prefix(most);
    const unit = chart.unit.includes(',') ? chart.unit : `${letter}${chart.unit}`;
    const factor = chart.unit.includes(',') ? 1 : scale;
    const { data, series, bands } = table(chart, factor);
    const box = element('div', { class: 'plot' });
    const values = element('p', { class: 'values' });
    const heading = element('h3', {}, chart.title);
    const figure = element('section', { class: 'chart', 'aria-label': chart.title }, heading, values, box);
    this.host.append(figure);
    const axis = () => ({ stroke: colour('muted'), grid: { stroke: colour('grid'), width: 1 }, ticks: { show: false }, font: '11px system-ui, sans-serif' });
    const plot = new uPlot({
      width: this.#width(), height: last ? 160 : 134, series, bands,
      legend: { show: false }, cursor: { show: false }, padding: [6, 10, 0, 0],
      scales: { x: { time: false, range: () => this.range }, y: { range: [(low - room) / factor, (high + room) / factor] } },
      axes: [
        { ...axis(), size: last ? 22 : 8, label: last ? 'time / s' : undefined, labelSize: 18, labelGap: 0, labelFont: '11px system-ui, sans-serif', values: last ? undefined : () => [] },
        { ...axis(), size: GUTTER, label: unit, labelSize: 16, labelGap: 0, labelFont: '11px system-ui, sans-serif' },
      ],
      hooks: { drawClear: [(u) => this.#marks(u, chart)], draw: [(u) => this.#limits(u, near.map((x) => x / factor))] },
    }, data, box);
    const line = element('i', { class: 'now' });
    plot.over.append(line);
    this.#drag(plot);
    return { chart, plot, line, values, limits };
  }

  /** Stretches and lines of events, under the curves. */
  #marks(u, chart) {
    const { ctx, bbox } = u;
    const joint = chart.joint;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const event of this.events) {
      if (event.joint !== undefined && event.joint !== null && joint !== undefined && event.joint !== joint) continue;
      const from = u.valToPos(event.at, 'x', true);
      const to = u.valToPos(event.to ?? event.at, 'x', true);
      ctx.fillStyle = colour(`event-${event.kind}`);
      if (event.kind === 'push') ctx.fillRect(from, bbox.top, Math.max(to - from, 2), bbox.height);
      else if (event.kind === 'limit') ctx.fillRect(from, bbox.top + bbox.height - 5, Math.max(to - from, 2), 5);
      else ctx.fillRect(from - 0.5, bbox.top, event.kind === 'waypoint' ? 1 : 2, bbox.height);
    }
    ctx.restore();
  }

  #limits(u, limits) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.strokeStyle = colour('limit');
    ctx.setLineDash([6, 4]);
    ctx.lineWidth = devicePixelRatio;
    for (const limit of limits) {
      const y = u.valToPos(limit, 'y', true);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    ctx.restore();
  }

  /** A press or a drag on a chart sets the clock. */
  #drag(plot) {
    const { over } = plot;
    const set = (event) => {
      const { left } = over.getBoundingClientRect();
      this.clock.set(plot.posToVal(event.clientX - left, 'x'));
    };
    over.addEventListener('pointerdown', (event) => {
      over.setPointerCapture(event.pointerId);
      set(event);
    });
    over.addEventListener('pointermove', (event) => {
      if (over.hasPointerCapture(event.pointerId)) set(event);
    });
  }

  /** Bring line and values to the clock. */
  follow() {
    const { t } = this.clock;
    for (const { chart, plot, line, values, limits } of this.made) {
      line.style.transform = `translateX(${plot.valToPos(t, 'x')}px)`;
      line.hidden = t < this.range[0] || t > this.range[1];
      const items = chart.curves.map((made) => {
        const value = isOver(made.run, t) ? NaN : made.at[rowAt(made.run, t)];
        return element('span', { style: `--pen:${made.pen.stroke}` }, `${made.name} `, element('b', {}, engineering(value, made.unit)));
      });
      if (limits.length) {
        const both = limits.length === 2 && limits[0] === -limits[1] ? `\u00b1${engineering(limits[1], chart.unit)}` : limits.map((x) => engineering(x, chart.unit)).join(' to ');
        items.push(element('span', { class: 'bound' }, `${chart.bound ?? 'limit'} ${both}`));
      }
      values.replaceChildren(...items);
    }
  }

  /** Zoom the time axis by a factor about the clock. */
  zoom(factor) {
    const { t, end, step } = this.clock;
    const [from, to] = this.range;
    const middle = t >= from && t <= to ? t : (from + to) / 2;
    const span = Math.min(end, Math.max((to - from) * factor, 8 * step));
    const start = Math.max(0, Math.min(end - span, middle - span * ((middle - from) / (to - from))));
    this.range = [start, start + span];
    for (const { plot } of this.made) plot.setScale('x', { min: this.range[0], max: this.range[1] });
    this.follow();
  }

  #width() {
    return Math.max(240, this.host.clientWidth);
  }

  resize() {
    for (const { plot } of this.made) {
      if (Math.abs(plot.width - this.#width()) > 1) plot.setSize({ width: this.#width(), height: plot.height });
    }
    this.follow();
  }
}

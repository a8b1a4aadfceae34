// Charts that answer: drag to look closer, keys and buttons to zoom and pan, a cursor that reads off, names that switch.
'use strict';
(() => {
  const WIDE = 20000, HIGH = 10000, SVG = document.querySelector('.plot')?.namespaceURI;
  const number = new Intl.NumberFormat('en', { maximumSignificantDigits: 4, useGrouping: false });
  const made = (name, attributes, parent) => {
    const svg = ['line', 'text', 'rect'].includes(name);
    const element = svg ? document.createElementNS(SVG, name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    parent.append(element);
    return element;
  };

  // points of a path as this program writes them: M x y, then steps after l; dots are M x y h0
  const points = path => {
    const found = [];
    for (const piece of path.getAttribute('d').split('M').slice(1)) {
      const [x, y, ...steps] = piece.replace('h0', '').replace('l', ' ').split(' ').map(Number);
      let at = [x, y];
      found.push(at);
      for (let k = 2; k + 1 < steps.length; k += 2) found.push(at = [at[0] + steps[k], at[1] + steps[k + 1]]);
    }
    return found;
  };

  const ticks = (low, high, count, logarithmic) => {
    const least = (high - low) / count, power = 10 ** Math.floor(Math.log10(least));
    if (logarithmic && high - low > 0.6) {
      const all = [];
      for (let d = Math.floor(low); d <= high; d++) for (const f of [1, 2, 5]) all.push(d + Math.log10(f));
      return all.filter(v => v >= low && v <= high);
    }
    const step = [1, 2, 5, 10].map(m => m * power).find(s => s >= least), all = [];
    for (let k = Math.ceil(low / step); k * step <= high; k++) all.push(k * step);
    return all;
  };

  const plotOf = svg => {
    const [marks, grid] = [svg.querySelector('.marks'), svg.querySelector('.grid')];
    const [x, y] = [svg.dataset.x, svg.dataset.y].map(text => text.split(' ').map(Number));
    const series = [...marks.querySelectorAll('.line, .dots')].map(path => ({
      path, name: path.dataset.name, points: points(path), line: path.classList.contains('line'),
    }));
    return { svg, marks, grid, x, y, series, log: svg.dataset.log, whole: grid.innerHTML };
  };

  const value = (range, share, logarithmic) => {
    const v = range[0] + share * (range[1] - range[0]);
    return logarithmic ? 10 ** v : v;
  };
  const shown = v => number.format(v).replace('-', '−');

  const setUp = chart => {
    const plots = [...chart.querySelectorAll('.plot')].map(plotOf);
    if (!plots.length) return;
    const legend = chart.querySelector('.legend');
    const reading = made('output', { class: 'reading', 'aria-live': 'polite' }, chart);
    let view = [0, 1], cursor = null, from = null;
    const hidden = new Set();
    const visible = plot => plot.series.filter(s => !hidden.has(s.name));

    // the part of y that holds what is visible; the whole of it where all of x is
    const heights = plot => {
      if (view[0] <= 0 && view[1] >= 1) return [0, HIGH];
      let [low, high] = [HIGH, 0];
      for (const { points } of visible(plot)) for (const [px, py] of points) {
        if (px >= view[0] * WIDE && px <= view[1] * WIDE) { low = Math.min(low, py); high = Math.max(high, py); }
      }
      if (high <= low) return [0, HIGH];
      const room = 0.06 * (high - low);
      return [low - room, high + room];
    };

    const draw = () => {
      for (const plot of plots) {
        const [top, bottom] = heights(plot), [left, right] = view;
        plot.box = [top, bottom];
        plot.marks.setAttribute('viewBox', `${left * WIDE} ${top} ${(right - left) * WIDE} ${bottom - top}`);
        if (left <= 0 && right >= 1) { plot.grid.innerHTML = plot.whole; continue; }
        plot.grid.textContent = '';
        const across = [left, right].map(s => value(plot.x, s)), up = [1 - bottom / HIGH, 1 - top / HIGH].map(s => value(plot.y, s));
        ticks(...across, 8, plot.log.includes('x')).forEach((v, k) => {
          const at = 100 * (v - across[0]) / (across[1] - across[0]) + '%';
          made('line', { x1: at, x2: at, y1: 0, y2: '100%' }, plot.grid);
          made('text', { class: k % 2 ? 'x odd' : 'x', x: at, y: '100%', dy: 18 }, plot.grid).textContent = shown(value([v, v], 0, plot.log.includes('x')));
        });
        ticks(...up, Math.max(2, plot.svg.clientHeight / 34), plot.log.includes('y')).forEach(v => {
          const at = 100 - 100 * (v - up[0]) / (up[1] - up[0]) + '%';
          made('line', { x1: 0, x2: '100%', y1: at, y2: at }, plot.grid);
          made('text', { class: 'y', x: -6, y: at, dy: 4 }, plot.grid).textContent = shown(value([v, v], 0, plot.log.includes('y')));
        });
      }
      read();
    };

    const read = () => {
      chart.querySelectorAll('.cursor').forEach(line => line.remove());
      if (cursor === null) { reading.textContent = ''; return; }
      const share = (cursor - view[0]) / (view[1] - view[0]);
      const texts = [];
      for (const plot of plots) {
        if (share >= 0 && share <= 1) made('line', { class: 'cursor', x1: 100 * share + '%', x2: 100 * share + '%', y1: 0, y2: '100%' }, plot.svg);
        for (const { name, points } of visible(plot)) {
          if (!points.length) continue;
          const near = points.reduce((best, p) => Math.abs(p[0] - cursor * WIDE) < Math.abs(best[0] - cursor * WIDE) ? p : best);
          texts.push(`${name || ''} ${shown(value(plot.y, 1 - near[1] / HIGH, plot.log.includes('y')))}`.trim());
        }
      }
      const { x, log } = plots[0];
      reading.textContent = `${chart.querySelector('.horizontal').textContent}: ${shown(value(x, cursor, log.includes('x')))} · ${texts.join(' · ')}`;
    };

    const look = (left, right) => {
      const width = Math.min(1, Math.max(right - left, 0.002));
      left = Math.min(Math.max(0, left), 1 - width);
      view = [left, left + width];
      draw();
    };
    const zoom = factor => {
      const middle = cursor !== null && cursor > view[0] && cursor < view[1] ? cursor : (view[0] + view[1]) / 2;
      look(middle + factor * (view[0] - middle), middle + factor * (view[1] - middle));
    };
    const pan = share => look(view[0] + share * (view[1] - view[0]), view[1] + share * (view[1] - view[0]));
    const step = share => {
      cursor = Math.min(view[1], Math.max(view[0], (cursor ?? (view[0] + view[1]) / 2) + share * (view[1] - view[0])));
      read();
    };

    const tools = made('span', { class: 'tools' }, legend);
    for (const [text, label, act] of [
      ['←', 'move left', () => pan(-0.25)], ['→', 'move right', () => pan(0.25)], ['+', 'zoom in', () => zoom(0.5)],
      ['−', 'zoom out', () => zoom(2)], ['whole', 'show the whole', () => look(0, 1)],
    ]) {
      const button = made('button', { type: 'button', 'aria-label': label, title: label }, tools);
      button.textContent = text;
      button.addEventListener('click', act);
    }
    legend.querySelectorAll('.switch').forEach(button => button.addEventListener('click', () => {
      const name = button.textContent, off = !hidden.delete(name);
      if (off) hidden.add(name);
      button.setAttribute('aria-pressed', String(!off));
      chart.querySelectorAll('.marks [data-name]').forEach(path => path.classList.toggle('off', hidden.has(path.dataset.name)));
      draw();
    }));

    const keys = {
      '+': () => zoom(0.5), '=': () => zoom(0.5), '-': () => zoom(2), '0': () => look(0, 1), Escape: () => { cursor = null; look(0, 1); },
      ArrowLeft: e => e.shiftKey ? pan(-0.1) : step(-0.01), ArrowRight: e => e.shiftKey ? pan(0.1) : step(0.01),
    };
    for (const { svg } of plots) {
      const at = e => {
        const box = svg.getBoundingClientRect();
        return view[0] + Math.min(1, Math.max(0, (e.clientX - box.left) / box.width)) * (view[1] - view[0]);
      };
      let chosen = null;
      const done = () => { chosen?.remove(); chosen = from = null; };
      svg.addEventListener('keydown', e => { if (keys[e.key] && !e.ctrlKey && !e.metaKey) { e.preventDefault(); keys[e.key](e); } });
      svg.addEventListener('pointerdown', e => { from = at(e); svg.setPointerCapture(e.pointerId); });
      svg.addEventListener('pointermove', e => {
        cursor = at(e);
        read();
        if (from === null) return;
        chosen ??= made('rect', { class: 'chosen', y: 0, height: '100%' }, svg);
        const [left, right] = [from, cursor].sort((a, b) => a - b).map(v => 100 * (v - view[0]) / (view[1] - view[0]));
        chosen.setAttribute('x', left + '%');
        chosen.setAttribute('width', right - left + '%');
      });
      svg.addEventListener('pointerup', e => {
        const ends = [from ?? at(e), at(e)].sort((a, b) => a - b);
        done();
        if (ends[1] - ends[0] > 0.02 * (view[1] - view[0])) look(...ends);
      });
      svg.addEventListener('pointercancel', done);
      svg.addEventListener('pointerleave', () => { if (from === null) { cursor = null; read(); } });
      svg.addEventListener('dblclick', () => look(0, 1));
    }
  };
  document.querySelectorAll('.chart').forEach(setUp);
})();

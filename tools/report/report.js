'use strict';
// Plots every document from the JSON that is in the page, and offers that JSON for download.
const source = document.getElementById('occlude-data').textContent;
const parsed = JSON.parse(source);
const documents = Array.isArray(parsed) ? parsed : [parsed];

// M. Okabe and K. Ito's colours, of a lightness that shows on white and on black.
const kColors = ['#2b8cd0', '#cc79a7', '#c98500', '#7a6fd0', '#56a0a8'];
const kDashes = [[], [7, 3], [2, 3]];
const kYardsticks = { frustum: '#8a8d91', opt: '#55b38f', ideal: '#009e73' };
const kChosen = '#d55e00';
const kMostAtFirst = 6;
const charts = [];

function themed() {
  const style = getComputedStyle(document.documentElement);
  Chart.defaults.color = style.getPropertyValue('--quiet').trim();
  Chart.defaults.borderColor = style.getPropertyValue('--line').trim();
}

function repaint() {
  themed();
  for (const chart of charts) {
    for (const scale of Object.values(chart.options.scales)) {
      scale.ticks.color = scale.title.color = Chart.defaults.color;
      scale.grid.color = Chart.defaults.borderColor;
    }
    chart.update();
  }
}

function axis(text, more) {
  return Object.assign({ title: { display: true, text: text }, ticks: {}, grid: {} }, more);
}

// A plot with one line per run. `points` gives the {x, y} of a run's line.
function plot(id, runs, across, up, points) {
  const canvas = document.getElementById(id);
  const chart = new Chart(canvas, {
    type: 'line',
    data: { datasets: runs.map(run => ({
      label: run.label, data: points(run), borderColor: run.color, backgroundColor: run.color,
      borderDash: run.dash, borderWidth: 1.75, pointRadius: run.frames.length > 1 ? 0 : 3,
      hidden: !run.shown })) },
    options: { maintainAspectRatio: false, parsing: false, normalized: true,
               interaction: { mode: 'nearest', axis: 'x', intersect: false },
               plugins: { legend: { display: false } },
               scales: { x: axis(across, { type: 'linear', ticks: { precision: 0 } }), y: axis(up, { beginAtZero: true }) } }
  });
  charts.push(chart);
  return chart;
}

function along(key) {
  return run => run.frames.filter(frame => frame[key] !== null)
                   .map(frame => ({ x: frame.frame, y: frame[key] }));
}

function distribution(run) {
  const times = run.frames.map(frame => frame.frame_ms).filter(ms => ms !== null);
  times.sort((a, b) => a - b);
  return times.map((ms, i) => ({ x: 100 * (i + 0.5) / times.length, y: ms }));
}

// One switch per run, for all plots of its document.
function add_toggles(index, runs, plots) {
  const bar = document.getElementById('toggles-' + index);
  const boxes = runs.map((run, i) => {
    const label = document.createElement('label');
    const box = document.createElement('input');
    const swatch = document.createElement('span');
    box.type = 'checkbox';
    box.checked = run.shown;
    swatch.className = 'swatch';
    swatch.style.borderTopColor = run.color;
    swatch.style.borderTopStyle = run.dash.length === 0 ? 'solid' : run.dash[0] > 2 ? 'dashed' : 'dotted';
    const mark = () => label.classList.toggle('off', !box.checked); // paper shows what is plotted
    mark();
    label.append(box, swatch, run.label);
    bar.append(label);
    box.addEventListener('change', () => {
      mark();
      plots.forEach(chart => {
        chart.setDatasetVisibility(i, box.checked);
        chart.update();
      });
    });
    return { box: box, mark: mark };
  });
  for (const [text, checked] of [['all', true], ['none', false]]) {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = text;
    button.addEventListener('click', () => {
      boxes.forEach(({ box, mark }) => {
        box.checked = checked;
        mark();
      });
      plots.forEach(chart => {
        runs.forEach((_, i) => chart.setDatasetVisibility(i, checked));
        chart.update();
      });
    });
    bar.append(button);
  }
}

function show(doc, index) {
  const timed = doc.runs.filter(run => run.frame_ms.median !== null && run.frames.length > 0);
  const section = document.getElementById('plots-' + index);
  if (timed.length === 0) {
    section.hidden = true;
    return;
  }
  const several = timed.some(run => run.hierarchy !== timed[0].hierarchy);
  const chosen = section.dataset.chosen;
  const trees = [...new Set(timed.map(run => run.hierarchy))];
  const others = [...new Set(timed.map(run => run.algorithm))]
                   .filter(name => name !== chosen && kYardsticks[name] === undefined);
  const runs = timed.map(run => {
    const own = run.algorithm === chosen ? kChosen : kYardsticks[run.algorithm];
    // One colour per algorithm, and one dash per tree.
    const i = Math.max(others.indexOf(run.algorithm), 0);
    const dash = trees.indexOf(run.hierarchy) + Math.floor(i / kColors.length);
    return { label: run.algorithm + (several ? ' on ' + run.hierarchy : ''), frames: run.frames,
             color: own ?? kColors[i % kColors.length],
             dash: kDashes[dash % kDashes.length],
             shown: timed.length <= kMostAtFirst || own !== undefined };
  });
  add_toggles(index, runs, [
    plot('time-' + index, runs, 'frame of the path', 'ms', along('frame_ms')),
    plot('ratio-' + index, runs, 'frame of the path', 'time / time of ideal', along('ratio_to_ideal')),
    plot('queries-' + index, runs, 'frame of the path', 'queries', along('queries')),
    plot('triangles-' + index, runs, 'frame of the path', 'triangles drawn', along('triangles_drawn')),
    plot('distribution-' + index, runs, '% of frames', 'ms or less', distribution)]);
}

function csv() {
  const plain = value => typeof value !== 'object' || value === null;
  const rows = documents.flatMap(doc => doc.runs.flatMap(run => run.frames.map(frame => Object.assign(
    { scene: doc.scene.name, path: doc.path, algorithm: run.algorithm, hierarchy: run.hierarchy }, frame))));
  const columns = [...new Set(rows.flatMap(row => Object.keys(row).filter(key => plain(row[key]))))];
  const quoted = value => value === null || value === undefined ? '' :
    typeof value === 'string' ? '"' + value.replaceAll('"', '""') + '"' : String(value);
  return [columns, ...rows.map(row => columns.map(key => quoted(row[key])))].map(row => row.join(',')).join('\n') + '\n';
}

function offer(id, type, text) {
  const link = document.getElementById(id);
  link.addEventListener('click', () => { link.href = URL.createObjectURL(new Blob([text()], { type: type })); });
}

Chart.defaults.animation = false;
Chart.defaults.font.size = 12;
themed();
documents.forEach(show);
offer('save-json', 'application/json', () => source);
offer('save-csv', 'text/csv', csv);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', repaint);
matchMedia('print').addEventListener('change', print => {
  if (print.matches) { // nobody unfolds paper
    document.querySelectorAll('details').forEach(details => { details.open = true; });
  }
  repaint();
  charts.forEach(chart => chart.resize());
});
document.documentElement.dataset.plotted = charts.length;

// Tables, charts and pictures of a report. Whatever comes from file names or messages is set as text, never as HTML.
(function () {
'use strict';

const data = JSON.parse(document.getElementById('data').textContent);
const byId = (id) => document.getElementById(id);

// Columns of data.rows, as written by reportJson().
const R = {dataset: 0, pair: 1, variation: 2, method: 3, status: 4, converged: 5, success: 6, source: 7, target: 8,
           degrees: 9, metres: 10, rmse: 11, truthRmse: 12, overlap: 13, confidence: 14, time: 15, cpu: 16, memory: 17,
           message: 18, pose: 19, lostAt: 20};

const state = {dataset: -1, variation: 0, hidden: new Set(), charts: []};

// ---------------------------------------------------------------------------------------------------------------------
// Small things

function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name === 'style') node.style.cssText = value;
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  for (const child of children.flat())
    if (child !== null && child !== undefined) node.append(child);
  return node;
}

const DASH = '\u2013';
/// A property that the object itself has: names come from users, and may be those of every object.
const own = (object, name) => Object.prototype.hasOwnProperty.call(object || {}, name) ? object[name] : undefined;
const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);

/// Three digits where it matters, never an exponent for everyday figures.
function figure(value, digits = 3) {
  if (!isNumber(value)) return DASH;
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= Math.pow(10, digits)) return size < 1e7 ? value.toFixed(0) : value.toExponential(2);
  if (size < 1e-4) return value.toExponential(1);
  return value.toPrecision(digits);
}
const percent = (value) => isNumber(value) ? (100 * value).toFixed(0) + ' %' : DASH;
const centimetres = (metres) => isNumber(metres) ? figure(100 * metres) : DASH;
const rateOf = (rate) => rate[1] > 0 ? rate[0] / rate[1] : null;

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const darkQuery = window.matchMedia('(prefers-color-scheme: dark)');
let printing = false;
const isDark = () => darkQuery.matches && !printing;

// Colours that differ in the dark too, distinguished further by dashes and marks.
const LIGHT = ['#0b5cad', '#d9600a', '#17834f', '#b02a6b', '#6c4bc1', '#8a6d00', '#0d8a94', '#c0392b', '#5b6675', '#7a3e12'];
const DARK = ['#62a8f0', '#ff9a4a', '#58c98c', '#f07bb4', '#ab94f5', '#d9bd3a', '#4fc9d3', '#ff8076', '#a9b4c2', '#d09a6a'];
const DASHES = [[], [7, 4], [2, 3]];
const MARKS = ['circle', 'triangle', 'rect', 'rectRot', 'star', 'crossRot'];
const colourOf = (method) => (isDark() ? DARK : LIGHT)[method % LIGHT.length];
const dashOf = (method) => DASHES[Math.floor(method / LIGHT.length) % DASHES.length];
const markOf = (method) => MARKS[(method + Math.floor(method / LIGHT.length)) % MARKS.length];
const swatch = (method) => element('span', {class: 'swatch ' + ['', 'dashed', 'dotted'][Math.floor(method / LIGHT.length) % 3],
                                            'data-method': method, style: 'color:' + colourOf(method)});

function groupsShown(withHidden) {
  return data.groups.filter((g) => g.dataset === state.dataset && g.variation === state.variation &&
                                   (withHidden || !state.hidden.has(g.method)));
}

function fillSelect(select, entries, value) {
  select.replaceChildren(...entries.map(([key, text]) => element('option', {value: key}, text)));
  select.value = String(value);
}

// ---------------------------------------------------------------------------------------------------------------------
// Tables that sort by their heads

/// columns: {title, unit, text, value(item) for sorting, cell(item) -> content, class}
function sortableTable(table, columns, options) {
  const view = {items: [], sort: options.sort ?? null, down: options.down ?? false};
  const heads = columns.map((column, index) => {
    const head = element('th', {scope: 'col', class: column.class, 'data-title': column.value ? column.title : null},
                         column.value ? element('button', {type: 'button', onclick: () => sortBy(index)}, column.title)
                                      : column.title || '',
                         column.unit ? element('span', {class: 'unit'}, column.unit) : null);
    return head;
  });
  const body = element('tbody');
  table.replaceChildren(element('thead', {}, element('tr', {}, heads)), body);

  function sortBy(index) {
    view.down = view.sort === index ? !view.down : false;
    view.sort = index;
    render();
  }
  function compare(a, b) {
    if (typeof a === 'string' || typeof b === 'string') return String(a).localeCompare(String(b), 'en', {numeric: true});
    return a - b;
  }
  function sorted() {
    if (view.sort === null) return view.items;
    const value = columns[view.sort].value;
    const missing = (v) => v === null || v === undefined || (typeof v === 'number' && Number.isNaN(v));
    const keyed = view.items.map((item, place) => ({item, place, key: value(item)}));
    keyed.sort((a, b) => {
      if (missing(a.key) || missing(b.key)) return missing(a.key) - missing(b.key) || a.place - b.place; // last both ways
      return (view.down ? -1 : 1) * compare(a.key, b.key) || a.place - b.place;
    });
    return keyed.map((entry) => entry.item);
  }
  function render() {
    heads.forEach((head, index) => {
      if (view.sort === index) head.setAttribute('aria-sort', view.down ? 'descending' : 'ascending');
      else head.removeAttribute('aria-sort');
    });
    options.render(body, sorted());
  }
  return {set(items) { view.items = items; render(); }, render};
}

const row = (columns, item) =>
    element('tr', {}, columns.map((column) => element('td', {class: column.class}, column.cell(item))));

// ---------------------------------------------------------------------------------------------------------------------
// Head

function describeRun() {
  const run = data.run || {}, settings = data.settings || {};
  const parts = [];
  if (run.date) parts.push(run.date);
  if (run.machine) parts.push(run.machine);
  if (settings.version) parts.push('pcl_ssfr ' + settings.version);
  const counts = data.rows_total + (data.rows_total === 1 ? ' run' : ' runs') + ' of ' + data.methods.length +
                 (data.methods.length === 1 ? ' method' : ' methods') + ' on ' + data.datasets.length +
                 (data.datasets.length === 1 ? ' dataset' : ' datasets');
  const subtitle = byId('subtitle');
  subtitle.append(counts + (parts.length ? ' \u00b7 ' + parts.join(' \u00b7 ') : ''));
  if (run.command) subtitle.append(element('br'), element('code', {}, run.command));
  if (!data.complete) {
    byId('partial').hidden = false;
    byId('partial').textContent = 'Partial: ' + data.rows_total + ' of ' + data.planned +
                                  ' runs are done; --resume goes on with the rest.';
  }
  byId('made-by').textContent = 'Written by ssfr_benchmark' + (settings.version ? ' ' + settings.version : '') +
                                '. All numbers of every run are in results.csv next to this file.';
}

function settingsTable() {
  const rows = [];
  const add = (name, value) => rows.push(element('tr', {}, element('th', {class: 'text', scope: 'row'}, name),
                                                 element('td', {class: 'text'}, value)));
  const settings = data.settings || {};
  const text = (value) => value !== null && typeof value === 'object' ? JSON.stringify(value) : String(value);
  for (const [name, value] of Object.entries(settings))
    if (value === null || typeof value !== 'object') add(name, text(value));
  for (const [name, value] of Object.entries(settings.datasets || {}))
    add('dataset ' + name, 'right within ' + text(value.success_rotation_deg) + '\u00b0 and ' +
                           text(value.success_translation_m) + ' m; viewpoint: ' + text(value.viewpoint));
  for (const [name, value] of Object.entries(settings.external || {})) add('program ' + name, text(value));
  for (const [name, value] of Object.entries(settings.parameters || {})) add(name, text(value));
  byId('settings').replaceChildren(element('tbody', {}, rows));
  byId('settings-json').textContent = JSON.stringify(settings, null, 2);
}

// ---------------------------------------------------------------------------------------------------------------------
// What is shown

function controls() {
  const datasets = [...new Set(data.groups.map((g) => g.dataset))].sort((a, b) => a - b);
  const name = (d) => d < 0 ? 'All datasets' : data.datasets[d];
  state.dataset = datasets.length ? datasets[0] : -1;
  fillSelect(byId('dataset'), datasets.map((d) => [d, name(d)]), state.dataset);
  byId('dataset-label').hidden = datasets.length < 2;
  fillSelect(byId('variation'), data.variations.map((v, i) => [i, v.text]), 0);
  byId('variation-label').hidden = data.variations.length < 2;
  byId('dataset').addEventListener('change', () => choose(Number(byId('dataset').value), state.variation));
  byId('variation').addEventListener('change', () => choose(state.dataset, Number(byId('variation').value)));
  byId('chips').append(...data.methods.map((method, m) => {
    const chip = element('button', {type: 'button', class: 'chip', 'aria-pressed': 'true'}, swatch(m), method);
    chip.addEventListener('click', () => {
      if (state.hidden.has(m)) state.hidden.delete(m);
      else state.hidden.add(m);
      chip.setAttribute('aria-pressed', String(!state.hidden.has(m)));
      drawCharts();
    });
    return chip;
  }));
}

function choose(dataset, variation) {
  if (!data.groups.some((g) => g.dataset === dataset && g.variation === variation)) {
    const other = data.groups.find((g) => g.dataset === dataset); // this dataset was not run under it
    variation = other ? other.variation : variation;
  }
  state.dataset = dataset;
  state.variation = variation;
  byId('dataset').value = String(dataset);
  byId('variation').value = String(variation);
  overview();
  summary.set(groupsShown(true));
  describeSelection();
  drawCharts();
}

function describeSelection() {
  const parts = [];
  parts.push(state.dataset < 0 ? 'All datasets' : data.datasets[state.dataset] ?? '');
  if (data.variations.length) parts.push(data.variations[state.variation].text);
  const bound = own((data.settings || {}).datasets, data.datasets[state.dataset]);
  if (bound) parts.push('right within ' + bound.success_rotation_deg + '\u00b0 and ' + bound.success_translation_m + ' m');
  byId('summary-caption').textContent = data.groups.length ? parts.join(' \u00b7 ') : 'No run has ended yet.';
}

/// Methods against datasets and variations; only when there is more than one of these.
function overview() {
  const places = [];
  for (const g of data.groups)
    if (g.dataset >= 0 && !places.some((p) => p.dataset === g.dataset && p.variation === g.variation))
      places.push({dataset: g.dataset, variation: g.variation});
  byId('overview-section').hidden = places.length < 2;
  if (places.length < 2) return;
  const cells = new Map(data.groups.map((g) => [[g.dataset, g.variation, g.method].join('/'), g]));
  const head = element('tr', {}, element('th', {class: 'name'}, 'method'), places.map((p) =>
      element('th', {scope: 'col'}, data.datasets[p.dataset],
              data.variations.length > 1 ? element('span', {class: 'unit'}, data.variations[p.variation].text) : null)));
  const rows = data.methods.map((method, m) => element('tr', {},
      element('th', {class: 'name', scope: 'row'}, swatch(m), method),
      places.map((p) => {
        const group = cells.get([p.dataset, p.variation, m].join('/'));
        if (!group) return element('td', {class: 'dim'}, DASH);
        const rate = rateOf(group.success);
        const chosen = p.dataset === state.dataset && p.variation === state.variation;
        const button = element('button', {type: 'button', 'aria-pressed': String(chosen),
                                          title: group.success[0] + ' of ' + group.success[1],
                                          onclick: () => choose(p.dataset, p.variation)}, percent(rate));
        const hue = 5 + 145 * (rate ?? 0);
        button.style.setProperty('--cell', 'hsl(' + hue.toFixed(0) + (isDark() ? ' 45% 24%)' : ' 62% 84%)'));
        return element('td', {}, button);
      })));
  byId('overview').replaceChildren(element('thead', {}, head), element('tbody', {}, rows));
}

function rateCell(rate) {
  const value = rateOf(rate);
  if (value === null) return DASH;
  const left = 100 * rate[2], width = 100 * (rate[3] - rate[2]);
  const track = element('span', {class: 'track', 'aria-hidden': 'true'}, element('i'), element('b'));
  track.children[0].style.left = left + '%';
  track.children[0].style.width = width + '%';
  track.children[1].style.left = 100 * value + '%';
  return element('span', {class: 'rate'}, element('strong', {}, percent(value)), ' ',
                 element('span', {class: 'dim'}, '[' + left.toFixed(0) + ', ' + (left + width).toFixed(0) + '] ' +
                                                 rate[0] + '/' + rate[1]), track);
}

const failuresText = (group) =>
    Object.entries(group.failures).sort((a, b) => b[1] - a[1]).map(([why, n]) => n + ' ' + why).join(', ') || DASH;

const summaryColumns = [
  {title: 'method', class: 'name', value: (g) => data.methods[g.method], cell: (g) => [swatch(g.method), data.methods[g.method]]},
  {title: 'success', unit: '95 % interval', class: 'text', value: (g) => rateOf(g.success), cell: (g) => rateCell(g.success)},
  {title: 'false positives', unit: 'of accepted', value: (g) => rateOf(g.wrong), cell: (g) => g.wrong[1] ?
      element('span', {class: g.wrong[0] ? 'badge wrong' : ''}, g.wrong[0] + ' of ' + g.wrong[1]) : DASH},
  {title: 'rotation error', unit: 'median \u00b0', value: (g) => g.degrees, cell: (g) => figure(g.degrees)},
  {title: 'translation error', unit: 'median cm', value: (g) => g.metres, cell: (g) => centimetres(g.metres)},
  {title: 'RMSE (truth)', unit: 'median cm', value: (g) => g.rmse,
   cell: (g) => [centimetres(g.rmse), ' ', element('span', {class: 'dim'}, '(' + centimetres(g.truth_rmse) + ')')]},
  {title: 'time', unit: 'median s', value: (g) => g.time, cell: (g) => figure(g.time)},
  {title: 'time', unit: '90 % s', value: (g) => g.time90, cell: (g) => figure(g.time90)},
  {title: 'CPU', unit: 'median s', value: (g) => g.cpu, cell: (g) => figure(g.cpu)},
  {title: 'memory', unit: 'peak MiB', value: (g) => g.memory, cell: (g) => figure(g.memory)},
  ...data.bounds.map((bound, i) => ({title: bound[0] + '\u00b0, ' + bound[1] + ' m', unit: 'within', class: 'bound',
                                     value: (g) => rateOf(g.within[i]), cell: (g) => percent(rateOf(g.within[i]))})),
  {title: 'not solved', class: 'text', cell: (g) => failuresText(g)},
];
const summary = sortableTable(byId('summary'), summaryColumns, {
  render: (body, items) => body.replaceChildren(...items.map((g) => row(summaryColumns, g)))});

// ---------------------------------------------------------------------------------------------------------------------
// Charts

/// Powers of ten, where there are two of them; else what the library would choose.
function decades(scale) {
  const powers = scale.ticks.filter(({value}) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9);
  if (powers.length > 1) scale.ticks = powers;
}
const LOG_TICKS = {autoSkip: true, autoSkipPadding: 6, maxTicksLimit: 8, maxRotation: 0, callback: (v) => String(Number(v.toPrecision(2)))};
const axis = (text, more) => Object.assign({title: {display: true, text, color: css('--dim')},
                                            ticks: {color: css('--dim')}, grid: {color: css('--line')}}, more);
const logAxis = (text, more) => {
  const result = axis(text, Object.assign({type: 'logarithmic', afterBuildTicks: decades}, more));
  result.ticks = Object.assign({color: css('--dim')}, LOG_TICKS);
  return result;
};
const shareAxis = (text) => {
  const result = axis(text, {type: 'linear', min: 0, max: 1});
  result.ticks.callback = (v) => (100 * v).toFixed(0) + ' %';
  return result;
};
const line = (group, points, more) => Object.assign({
  label: data.methods[group.method], data: points, borderColor: colourOf(group.method), backgroundColor: colourOf(group.method),
  borderDash: dashOf(group.method), borderWidth: 2, pointRadius: 0, pointHitRadius: 6, pointStyle: markOf(group.method),
  tension: 0}, more);

/// A sweep: a parameter that takes more than one value while all else stays as it is in the variation shown.
const distinct = (values) => new Set(data.variations.map(values)).size;
const SWEPT = [['resolution', 'resolution [m]'], ['noise', 'noise [m]'], ['outliers', 'share of outliers'],
               ['overlap', 'overlap limit']]
  .filter(([key]) => distinct((v) => JSON.stringify([v.rest, v[key]])) > distinct((v) => v.rest));
const SWEEP_MEASURES = {
  success: ['success', (g) => rateOf(g.success)],
  wrong: ['false positives', (g) => rateOf(g.wrong)],
  degrees: ['median rotation error [\u00b0]', (g) => g.degrees],
  metres: ['median translation error [m]', (g) => g.metres],
  rmse: ['median RMSE [m]', (g) => g.rmse],
  time: ['median time [s]', (g) => g.time],
};
const sweep = {parameter: SWEPT.length ? SWEPT[0][0] : null, measure: 'success'};

function sweepPoints(method) {
  const here = data.variations[state.variation];
  const others = ['resolution', 'noise', 'outliers', 'overlap'].filter((key) => key !== sweep.parameter);
  const points = [];
  for (const g of data.groups) {
    const v = data.variations[g.variation];
    if (g.method === method && g.dataset === state.dataset && v.rest === here.rest &&
        others.every((key) => v[key] === here[key])) {
      const y = SWEEP_MEASURES[sweep.measure][1](g);
      if (isNumber(y)) points.push({x: v[sweep.parameter], y});
    }
  }
  return points.sort((a, b) => a.x - b.x);
}

const BOX_SMALLEST = 1e-4;
function boxChart(key, title) {
  return {
    config() {
      const groups = groupsShown().filter((g) => g[key]);
      const clamp = (v) => Math.max(v, BOX_SMALLEST);
      return {type: 'boxplot', data: {labels: groups.map((g) => data.methods[g.method]), datasets: [{
        data: groups.map((g) => {
          const [low, q1, median, q3, high] = g[key].map(clamp);
          return {min: low, whiskerMin: low, q1, median, q3, whiskerMax: high, max: high, mean: median, items: [], outliers: []};
        }),
        backgroundColor: groups.map((g) => colourOf(g.method) + '55'), borderColor: groups.map((g) => colourOf(g.method)),
        borderWidth: 1.5, meanRadius: 0, itemRadius: 0, outlierRadius: 0, medianColor: css('--ink')}]},
        options: {indexAxis: 'y', scales: {x: logAxis(title), y: axis('', {title: {display: false}})},
                  plugins: {tooltip: {callbacks: {label: (item) => {
                    const [low, q1, median, q3, high] = groups[item.dataIndex][key];
                    return 'median ' + figure(median) + ', half in ' + figure(q1) + ' to ' + figure(q3) + ', 90 % in ' +
                           figure(low) + ' to ' + figure(high);
                  }}}}},
        rows: groups.length};
    }};
}

function errorCurve(bounds, curve, title) {
  return {config: () => ({type: 'line',
    data: {datasets: groupsShown().map((g) => line(g, data[bounds].map((x, i) => ({x, y: g[curve][i]}))))},
    options: {interaction: {mode: 'nearest', intersect: false},
              scales: {x: logAxis(title, {min: data[bounds][0], max: data[bounds][data[bounds].length - 1]}),
                       y: shareAxis('pairs within it')},
              plugins: {tooltip: {callbacks: {title: () => '', label: (item) =>
                item.dataset.label + ': ' + percent(item.parsed.y) + ' within ' + figure(item.parsed.x)}}}}})};
}

const FAILURE_LIGHT = {'wrong pose': '#c0392b', timeout: '#7a5c00', crashed: '#1c2430', ambiguous: '#d99a0a', no_candidate: '#8592a3',
                       failed: '#6c4bc1', bad_output: '#0d8a94', missing: '#b9c2cd', out_of_memory: '#b02a6b'};
const OTHER_FAILURES = ['#4b7bb5', '#7aa35a', '#b57b4b', '#9a6fb0', '#5aa39a', '#a35a6f'];
function failureColour(reason, place) {
  if (reason === 'crashed' && isDark()) return '#e4e9f0';
  return own(FAILURE_LIGHT, reason) ?? OTHER_FAILURES[place % OTHER_FAILURES.length];
}

const CHARTS = [
  {id: 'degree-curve', title: 'Success against rotation error', hint: 'Share of all pairs whose rotation error is within the threshold.',
   ...errorCurve('degree_bounds', 'degree_curve', 'rotation error [\u00b0]')},
  {id: 'metre-curve', title: 'Success against translation error', hint: 'Share of all pairs whose translation error is within the threshold.',
   ...errorCurve('metre_bounds', 'metre_curve', 'translation error [m]')},
  {id: 'time-success', title: 'Time against success', hint: 'Upper left is best. Bars: Wilson\u2019s 95 % interval of the success.',
   config: () => ({type: 'line', data: {datasets: groupsShown().filter((g) => isNumber(g.time) && g.success[1]).map((g) => {
     const x = Math.max(g.time, BOX_SMALLEST);
     return line(g, [{x, y: g.success[2]}, {x, y: rateOf(g.success)}, {x, y: g.success[3]}],
                 {borderDash: [], borderWidth: 1, pointRadius: [0, 6, 0], pointHoverRadius: [0, 8, 0], pointHitRadius: [0, 8, 0]});
   })},
     options: {clip: false, scales: {x: logAxis('median time [s]', {grace: '10%'}), y: shareAxis('success')},
               plugins: {tooltip: {callbacks: {title: () => '', label: (item) => item.dataset.label + ': ' +
                 percent(item.parsed.y) + ', ' + figure(item.parsed.x) + ' s'}}}}})},
  {id: 'precision-recall', title: 'Precision and recall over confidence',
   hint: 'Accepting answers from a confidence on: how many are right, and how many of all pairs are solved so.',
   empty: 'No method shown here states a confidence.',
   config() {
     const groups = groupsShown().filter((g) => g.precision_recall.length);
     if (!groups.length) return null;
     return {type: 'line', data: {datasets: groups.map((g) =>
       line(g, g.precision_recall.map(([confidence, y, x]) => ({x, y, confidence})), {pointRadius: g.precision_recall.length < 40 ? 3 : 0}))},
       options: {clip: false, scales: {x: shareAxis('recall'), y: shareAxis('precision')}, interaction: {mode: 'nearest', intersect: false},
                 plugins: {tooltip: {callbacks: {title: () => '', label: (item) => item.dataset.label + ': precision ' +
                   percent(item.parsed.y) + ', recall ' + percent(item.parsed.x) + ' from confidence ' + figure(item.raw.confidence)}}}}};
   }},
  {id: 'time-box', title: 'Time by method', hint: 'Median, quartiles, and the 5th and 95th percentile of all runs.', ...boxChart('time_box', 'time [s]')},
  {id: 'degree-box', title: 'Rotation error by method', hint: 'Median, quartiles, and the 5th and 95th percentile of all answers, wrong ones too.',
   ...boxChart('degree_box', 'rotation error [\u00b0]')},
  {id: 'metre-box', title: 'Translation error by method', hint: 'Median, quartiles, and the 5th and 95th percentile of all answers, wrong ones too.',
   ...boxChart('metre_box', 'translation error [m]')},
  {id: 'failures', title: 'Failures by reason', hint: 'Pairs that were not solved; wrong pose: the method said converged.',
   empty: 'No pair was left unsolved.', legend: true,
   config() {
     const groups = groupsShown();
     const reasons = [...new Set(data.groups.flatMap((g) => Object.keys(g.failures)))].sort();
     const used = reasons.filter((reason) => groups.some((g) => own(g.failures, reason)));
     if (!used.length) return null;
     return {type: 'bar', data: {labels: groups.map((g) => data.methods[g.method]), datasets: used.map((reason) => ({
       label: reason, data: groups.map((g) => own(g.failures, reason) || 0), backgroundColor: failureColour(reason, reasons.indexOf(reason)), maxBarThickness: 26}))},
       options: {indexAxis: 'y', scales: {x: axis('pairs', {stacked: true, ticks: {precision: 0, color: css('--dim')}}), y: axis('', {stacked: true, title: {display: false}})},
                 interaction: {mode: 'index', axis: 'y'}},
       rows: groups.length};
   }},
];
if (SWEPT.length) {
  CHARTS.unshift({id: 'sweep', title: 'Sweep', hint: 'Each method against the setting that was varied.', picks: true, empty: 'Nothing was varied here.',
    config() {
      const lines = groupsShown().map((g) => line(g, sweepPoints(g.method), {pointRadius: 4})).filter((set) => set.data.length);
      if (!lines.length) return null;
      const [name] = SWEEP_MEASURES[sweep.measure];
      const isShare = sweep.measure === 'success' || sweep.measure === 'wrong';
      const values = [...new Set(lines.flatMap((set) => set.data.map((p) => p.x)))].sort((a, b) => a - b);
      const title = SWEPT.find(([key]) => key === sweep.parameter)[1];
      return {type: 'line', data: {datasets: lines}, options: {clip: false,
        scales: {x: Object.assign(Math.min(...values) > 0 ? logAxis(title) : axis(title, {type: 'linear'}),
                                  {afterBuildTicks: (scale) => { scale.ticks = values.map((value) => ({value})); }}),
                 y: isShare ? shareAxis(name) : logAxis(name)},
        plugins: {tooltip: {callbacks: {title: () => '', label: (item) => item.dataset.label + ': ' +
          (isShare ? percent(item.parsed.y) : figure(item.parsed.y)) + ' at ' + figure(item.parsed.x)}}}}};
    }});
}

function layCharts() {
  byId('charts').append(...CHARTS.map((chart) => {
    const picks = element('div', {class: 'picks'});
    if (chart.picks) {
      const parameter = element('select', {'aria-label': 'What is varied'});
      fillSelect(parameter, SWEPT, sweep.parameter);
      parameter.addEventListener('change', () => { sweep.parameter = parameter.value; drawCharts(); });
      const measure = element('select', {'aria-label': 'What is measured'});
      fillSelect(measure, Object.entries(SWEEP_MEASURES).map(([key, [name]]) => [key, name]), sweep.measure);
      measure.addEventListener('change', () => { sweep.measure = measure.value; drawCharts(); });
      picks.append(measure, parameter);
    }
    return element('div', {class: 'chart', id: chart.id}, element('h3', {}, chart.title), element('p', {class: 'hint'}, chart.hint),
                   chart.picks ? picks : null, element('div', {class: 'plot'}), chart.legend ? element('div', {class: 'legend'}) : null);
  }));
}

function drawCharts() {
  for (const chart of state.charts) chart.destroy();
  state.charts = [];
  Chart.defaults.color = css('--dim');
  Chart.defaults.borderColor = css('--line');
  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  for (const chart of CHARTS) {
    const card = byId(chart.id), plot = card.querySelector('.plot'), legend = card.querySelector('.legend');
    const config = data.groups.length ? chart.config() : null;
    if (legend) legend.replaceChildren();
    plot.style.height = '';
    if (!config) {
      plot.replaceChildren(element('p', {class: 'dim'}, data.groups.length ? chart.empty || 'Nothing to show.' : 'No run has ended yet.'));
      plot.style.height = 'auto';
      continue;
    }
    if (config.rows > 11) plot.style.height = (80 + 22 * config.rows) + 'px'; // a line for each name
    delete config.rows;
    const canvas = element('canvas', {role: 'img', 'aria-label': chart.title});
    plot.replaceChildren(canvas);
    const options = config.options;
    options.animation = false;
    options.responsive = true;
    options.maintainAspectRatio = false;
    options.plugins = Object.assign({legend: {display: false}}, options.plugins);
    if (options.indexAxis === 'y') options.scales.y.ticks.autoSkip = false;
    state.charts.push(new Chart(canvas, config));
    if (legend)
      legend.append(...config.data.datasets.map((set) =>
          element('span', {}, element('i', {style: 'background:' + set.backgroundColor}), set.label)));
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Pictures of a pair

const pairs = new Map(data.pairs.map((pair) => [pair.dataset + '/' + pair.pair, pair]));
const clouds = new Map();

/// x, y, z of each point relative to the middle of its scan [m].
function cloudPoints(index) {
  if (!clouds.has(index)) {
    const text = atob(data.clouds[index].points), step = data.clouds[index].step;
    const bytes = Uint8Array.from(text, (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const points = new Float32Array(bytes.length / 2);
    for (let i = 0; i < points.length; ++i) points[i] = step * view.getInt16(2 * i, true);
    clouds.set(index, points);
  }
  return clouds.get(index);
}

/// Points moved by a pose: quaternion w, x, y, z and translation.
function moved(points, [w, x, y, z, tx, ty, tz]) {
  const m = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
             2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
             2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
  const result = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) {
    const [a, b, c] = [points[i], points[i + 1], points[i + 2]];
    result[i] = m[0] * a + m[1] * b + m[2] * c + tx;
    result[i + 1] = m[3] * a + m[4] * b + m[5] * c + ty;
    result[i + 2] = m[6] * a + m[7] * b + m[8] * c + tz;
  }
  return result;
}

/// The box that holds all but the outermost hundredth of the points along an axis.
function reach(list, axisIndex) {
  const values = [];
  for (const points of list)
    for (let i = axisIndex; i < points.length; i += 3) values.push(points[i]);
  values.sort((a, b) => a - b);
  if (!values.length) return [-1, 1];
  const at = (share) => values[Math.round(share * (values.length - 1))];
  return [at(0.005), at(0.995)];
}

function roundLength(longest) {
  const power = Math.pow(10, Math.floor(Math.log10(longest)));
  return [5, 2, 1].map((n) => n * power).find((length) => length <= longest);
}

/// Two clouds seen along an axis; [right, up] are the axes of the view.
function drawView(canvas, target, source, [right, up]) {
  const width = canvas.clientWidth || 320;
  const [left, rightEnd] = reach([target, source], right), [bottom, top] = reach([target, source], up);
  const spanX = Math.max(rightEnd - left, 1e-3), spanY = Math.max(top - bottom, 1e-3);
  const margin = 10, foot = 24; // the scale bar's
  const height = Math.min(Math.max((width - 2 * margin) * spanY / spanX + margin + foot, 0.3 * width), 0.8 * width);
  const ratio = Math.max(window.devicePixelRatio || 1, printing ? 2 : 1);
  canvas.style.height = height + 'px';
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.clearRect(0, 0, width, height);
  const scale = Math.min((width - 2 * margin) / spanX, (height - margin - foot) / spanY);
  const offsetX = width / 2 - scale * (left + rightEnd) / 2, offsetY = (height + margin - foot) / 2 + scale * (bottom + top) / 2;
  const size = width > 300 ? 1.7 : 1.4;
  for (const [points, colour] of [[target, css('--target')], [source, css('--source')]]) {
    context.fillStyle = colour;
    context.globalAlpha = 0.8;
    for (let i = 0; i < points.length; i += 3)
      context.fillRect(offsetX + scale * points[i + right] - size / 2, offsetY - scale * points[i + up] - size / 2, size, size);
  }
  context.globalAlpha = 1;
  const length = roundLength(0.35 * width / scale);
  const label = Number(length.toPrecision(1)) + ' m';
  context.font = '11px ' + getComputedStyle(document.body).fontFamily;
  context.fillStyle = css('--card');
  context.fillRect(4, height - 22, Math.max(length * scale, context.measureText(label).width) + 8, 22);
  context.strokeStyle = context.fillStyle = css('--dim');
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(8, height - 6);
  context.lineTo(8 + length * scale, height - 6);
  context.stroke();
  context.fillText(label, 8, height - 10);
}

const drawings = new Set();
function redrawPictures() {
  for (const draw of drawings)
    if (!draw()) drawings.delete(draw);
}

function picture(title, pair, pose, missing) {
  const box = element('div', {class: 'picture'}, element('h3', {}, title));
  if (!pose) {
    box.append(element('p', {class: 'dim'}, missing));
    return box;
  }
  const target = cloudPoints(pair.target), source = moved(cloudPoints(pair.source), pose);
  const views = [['from above', [0, 1]], ['from the side', [0, 2]]].map(([name, axes]) => {
    const canvas = element('canvas', {role: 'img', 'aria-label': title + ', ' + name});
    box.append(element('div', {class: 'view'}, name), canvas);
    return [canvas, axes];
  });
  const draw = () => {
    if (!box.isConnected) return false;
    for (const [canvas, axes] of views) drawView(canvas, target, source, axes);
    return true;
  };
  drawings.add(draw);
  requestAnimationFrame(draw);
  return box;
}

// ---------------------------------------------------------------------------------------------------------------------
// Every run

function verdictOf(r) {
  if (r[R.success]) return r[R.converged] ? 'right' : 'unsure';
  return r[R.converged] ? 'wrong' : 'none';
}
const VERDICTS = {right: 'right', unsure: 'right, not accepted', wrong: 'false positive', none: 'not solved'};
const scanName = (r) => data.scans[r[R.source]] + ' \u2192 ' + data.scans[r[R.target]];

function details(r) {
  const box = element('div', {class: 'detail-box'});
  const verdict = verdictOf(r);
  box.append(element('p', {}, element('span', {class: 'badge ' + verdict}, VERDICTS[verdict]), ' ',
                     element('strong', {}, data.methods[r[R.method]]), ' on ', scanName(r), ': ', data.statuses[r[R.status]],
                     r[R.message] ? ' \u2013 ' + r[R.message] : ''));
  const facts = [['rotation error', figure(r[R.degrees]) + '\u00b0'], ['translation error', figure(r[R.metres]) + ' m'],
                 ['RMSE', figure(r[R.rmse]) + ' m (truth ' + figure(r[R.truthRmse]) + ' m)'], ['overlap', percent(r[R.overlap])],
                 ['confidence', isNumber(r[R.confidence]) ? r[R.confidence].toFixed(2) : DASH], ['time', figure(r[R.time]) + ' s'], ['CPU', figure(r[R.cpu]) + ' s'],
                 ['memory', figure(r[R.memory]) + ' MiB']];
  if (r[R.lostAt]) facts.push(['truth lost at', r[R.lostAt]]);
  box.append(element('p', {class: 'facts'}, facts.map(([name, value]) => name + ' ' + value).join(' \u00b7 ')));
  const pair = pairs.get(r[R.dataset] + '/' + r[R.pair]);
  if (!pair) {
    box.append(element('p', {class: 'dim'}, 'This report holds no pictures of this pair; --pictures N asks for more.'));
    return box;
  }
  box.append(element('p', {}, element('span', {class: 'key'}, element('i', {style: 'background:var(--source)'}), 'source'),
                     element('span', {class: 'key'}, element('i', {style: 'background:var(--target)'}), 'target')));
  const variation = data.variations[r[R.variation]];
  box.append(element('div', {class: 'pictures'},
                     picture('Before', pair, pair.before[r[R.variation]], 'Not known.'),
                     picture('After ' + data.methods[r[R.method]], pair, r[R.pose], 'The method gave no pose.'),
                     picture('Ground truth', pair, pair.truth, '')));
  if (variation.noise || variation.outliers || variation.overlap)
    box.append(element('p', {class: 'hint'}, 'The scans are drawn as they are in the files, without the noise, outliers or cut of this run.'));
  return box;
}

const runColumns = [
  {title: '', class: 'name', cell: () => ''},
  {title: 'method', class: 'text', value: (r) => data.methods[r[R.method]], cell: (r) => [swatch(r[R.method]), ' ' + data.methods[r[R.method]]]},
  {title: 'result', class: 'text', value: (r) => Object.keys(VERDICTS).indexOf(verdictOf(r)),
   cell: (r) => element('span', {class: 'badge ' + verdictOf(r)}, VERDICTS[verdictOf(r)])},
  ...(data.datasets.length > 1 ? [{title: 'dataset', class: 'text', value: (r) => data.datasets[r[R.dataset]],
                                   cell: (r) => data.datasets[r[R.dataset]]}] : []),
  {title: 'pair', value: (r) => r[R.pair], cell: (r) => r[R.pair]},
  {title: 'scans', class: 'text', value: scanName, cell: (r) => scanName(r)},
  ...(data.variations.length > 1 ? [{title: 'variation', class: 'text', value: (r) => r[R.variation],
                                     cell: (r) => data.variations[r[R.variation]].text}] : []),
  {title: 'status', class: 'text', value: (r) => data.statuses[r[R.status]], cell: (r) => data.statuses[r[R.status]]},
  {title: 'rotation', unit: 'error \u00b0', value: (r) => r[R.degrees], cell: (r) => figure(r[R.degrees])},
  {title: 'translation', unit: 'error cm', value: (r) => r[R.metres], cell: (r) => centimetres(r[R.metres])},
  {title: 'RMSE', unit: 'cm', value: (r) => r[R.rmse], cell: (r) => centimetres(r[R.rmse])},
  {title: 'overlap', value: (r) => r[R.overlap], cell: (r) => percent(r[R.overlap])},
  {title: 'confidence', value: (r) => r[R.confidence], cell: (r) => isNumber(r[R.confidence]) ? r[R.confidence].toFixed(2) : DASH},
  {title: 'time', unit: 's', value: (r) => r[R.time], cell: (r) => figure(r[R.time])},
  {title: 'CPU', unit: 's', value: (r) => r[R.cpu], cell: (r) => figure(r[R.cpu])},
  {title: 'memory', unit: 'MiB', value: (r) => r[R.memory], cell: (r) => figure(r[R.memory])},
  {title: 'message', class: 'text', value: (r) => r[R.message], cell: (r) => r[R.message]},
];

const paging = {size: 50, page: 0, opened: new Set()};

/// Only one page of the rows is in the document, so that long runs stay usable.
function renderRuns(body, items) {
  const pages = Math.max(1, Math.ceil(items.length / paging.size));
  paging.page = Math.min(paging.page, pages - 1);
  const shown = items.slice(paging.page * paging.size, (paging.page + 1) * paging.size);
  const nodes = [];
  for (const r of shown) {
    const opener = element('button', {type: 'button', class: 'opener', 'aria-expanded': 'false', 'aria-label': 'Pictures and reason'}, '\u25b8');
    const node = row(runColumns, r);
    node.className = 'run';
    node.firstChild.replaceChildren(opener);
    const show = (open) => {
      opener.setAttribute('aria-expanded', String(open));
      if (open) {
        paging.opened.add(r);
        node.after(element('tr', {class: 'detail'}, element('td', {colspan: runColumns.length}, details(r))));
      } else if (node.nextSibling && node.nextSibling.className === 'detail') {
        paging.opened.delete(r);
        node.nextSibling.remove();
      }
    };
    node.addEventListener('click', () => {
      if (!String(window.getSelection())) show(opener.getAttribute('aria-expanded') === 'false');
    });
    nodes.push({node, show, r});
  }
  body.replaceChildren(...nodes.map((n) => n.node));
  for (const n of nodes)
    if (paging.opened.has(n.r)) n.show(true);
  if (!shown.length)
    body.append(element('tr', {}, element('td', {colspan: runColumns.length, class: 'text dim'},
                                          data.rows.length ? 'No run is like that.' : 'No run has ended yet.')));
  byId('count').textContent = items.length + ' of ' + data.rows.length + (data.rows.length === 1 ? ' run' : ' runs') +
                              '. Press a row for its pictures and the reason of a failure.';
  const go = (page) => { paging.page = page; runs.render(); };
  const size = element('select', {'aria-label': 'Rows a page'});
  fillSelect(size, [[25, '25'], [50, '50'], [100, '100'], [500, '500']], paging.size);
  size.addEventListener('change', () => { paging.size = Number(size.value); go(0); });
  byId('pager').replaceChildren(
      element('button', {type: 'button', disabled: paging.page === 0, onclick: () => go(0), 'aria-label': 'First page'}, '\u00ab'),
      element('button', {type: 'button', disabled: paging.page === 0, onclick: () => go(paging.page - 1)}, 'Previous'),
      'page ' + (paging.page + 1) + ' of ' + pages,
      element('button', {type: 'button', id: 'next', disabled: paging.page >= pages - 1, onclick: () => go(paging.page + 1)}, 'Next'),
      element('button', {type: 'button', disabled: paging.page >= pages - 1, onclick: () => go(pages - 1), 'aria-label': 'Last page'}, '\u00bb'),
      element('label', {}, 'rows a page', size));
}
const runs = sortableTable(byId('runs'), runColumns, {render: renderRuns});

function filterRuns() {
  const pick = (id) => byId(id).value;
  const dataset = pick('filter-dataset'), variation = pick('filter-variation'), method = pick('filter-method');
  const verdict = pick('filter-verdict'), status = pick('filter-status'), text = pick('filter-text').trim().toLowerCase();
  const hasText = (r) => [scanName(r), r[R.message], data.methods[r[R.method]], data.datasets[r[R.dataset]]]
      .some((part) => part.toLowerCase().includes(text));
  paging.page = 0;
  runs.set(data.rows.filter((r) => (dataset === '' || r[R.dataset] === Number(dataset)) &&
      (variation === '' || r[R.variation] === Number(variation)) && (method === '' || r[R.method] === Number(method)) &&
      (status === '' || r[R.status] === Number(status)) &&
      (verdict === '' || verdictOf(r) === verdict || (verdict === 'unsolved' && !r[R.success])) && (text === '' || hasText(r))));
}

function filters() {
  const all = (names) => [['', 'all'], ...names.map((name, i) => [i, name])];
  fillSelect(byId('filter-dataset'), all(data.datasets), '');
  fillSelect(byId('filter-variation'), all(data.variations.map((v) => v.text)), '');
  byId('filter-variation-label').hidden = data.variations.length < 2;
  fillSelect(byId('filter-method'), all(data.methods), '');
  fillSelect(byId('filter-verdict'), [['', 'all'], ...Object.entries(VERDICTS), ['unsolved', 'wrong or not solved']], '');
  fillSelect(byId('filter-status'), all(data.statuses), '');
  for (const select of byId('filters').querySelectorAll('select')) select.addEventListener('change', filterRuns);
  let waiting = 0;
  byId('filter-text').addEventListener('input', () => {
    clearTimeout(waiting);
    waiting = setTimeout(filterRuns, 120);
  });
  byId('filters').addEventListener('submit', (event) => event.preventDefault());
  byId('filter-clear').addEventListener('click', () => {
    byId('filters').reset();
    filterRuns();
  });
  if (data.rows.length < data.rows_total) {
    byId('rows-note').hidden = false;
    byId('rows-note').textContent = 'The table holds ' + data.rows.length + ' of ' + data.rows_total + ' runs, those not solved ' +
                                    'first; sums and charts are of all, and results.csv lists all.';
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// All of it

function recolour() {
  for (const node of document.querySelectorAll('.swatch[data-method]'))
    node.style.color = colourOf(Number(node.dataset.method));
  overview();
  drawCharts();
  redrawPictures();
}

describeRun();
settingsTable();
controls();
layCharts();
filters();
choose(state.dataset, state.variation);
filterRuns();
darkQuery.addEventListener('change', recolour);
/// The page is laid out as on paper before it is printed: a canvas does not follow by itself.
function forPaper(on) {
  printing = on;
  document.documentElement.classList.toggle('printing', on);
  recolour();
}
window.addEventListener('beforeprint', () => forPaper(true));
window.addEventListener('afterprint', () => forPaper(false));
let resized = 0;
window.addEventListener('resize', () => {
  clearTimeout(resized);
  resized = setTimeout(redrawPictures, 150);
});
})();

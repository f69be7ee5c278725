// A row for each process: its newest status, and plots of the last minutes.

const kMaxSamples = 900;
const kSpan = 300;  // s that a plot of a running graph shows

const kColumns = [
  {name: 'rate', title: 'rate, Hz', fields: ['rate_hz'], value: (s) => s.rate_hz.toFixed(1)},
  {name: 'age', title: 'age p50 / p99, ms', fields: ['age_p50_ms', 'age_p99_ms'],
   value: (s) => `${s.age_p50_ms.toFixed(0)} / ${s.age_p99_ms.toFixed(0)}`},
  {name: 'lost', title: 'skipped', fields: ['lost'], steps: true, value: lostOf},
  {name: 'bad', title: 'bad', fields: ['bad'], steps: true, value: (s) => s.bad_messages},
  {name: 'memory', title: 'memory, MB', fields: ['rss_mb'], value: (s) => (s.rss_bytes / 2 ** 20).toFixed(0)},
];
const kLines = ['#6fb3a8', '#d9a648'];

function lostOf(s) {
  return s.frames_skipped + s.frames_incomplete + s.frames_failed + s.frames_degenerate + s.sequence_gaps;
}

export class Plots {
  constructor(root) {
    this.root = root;
    this.courses = {};
    this.rows = new Map();
    this.table = document.createElement('table');
    const head = this.table.createTHead().insertRow();
    for (const title of ['process', 'frames', ...kColumns.map((column) => column.title), 'newest complaint']) {
      const cell = document.createElement('th');
      cell.textContent = title;
      head.append(cell);
    }
    this.body = this.table.createTBody();
    this.remark = document.createElement('p');
    root.append(this.table, this.remark);
  }

  /// Takes the statuses from before the page was opened. @param whole  plots show all (a log).
  start(history, whole) {
    [this.courses, this.whole] = [history, whole];
  }

  /// Takes note of a board, as sprout-top --json has it, and draws the newest one with the next
  /// picture: a page that wakes finds those of a minute, and drawing all of them takes seconds.
  update(board, seconds) {
    if (!this.whole) {
      for (const status of board.stages) {
        if (status.pid !== undefined) this.addSample(status, seconds);
      }
    }
    if (!this.board) requestAnimationFrame(() => this.show());
    this.board = board;
  }

  show() {
    const board = this.board;
    this.board = undefined;  // first: whatever happens here, the next board is drawn
    this.remark.textContent = board.configurations ?? '';
    const names = new Set();
    for (const status of board.stages) {
      const name = status.pid === undefined ? status.stage : `${status.stage} ${status.host}:${status.pid}`;
      names.add(name);
      if (!this.rows.has(name)) this.rows.set(name, this.addRow(status.stage));
      const row = this.rows.get(name);
      this.body.append(row.row);  // in the order of the board
      this.fillRow(row, status);
    }
    for (const [name, {row}] of this.rows) {
      if (names.has(name)) continue;
      row.remove();
      this.rows.delete(name);
    }
  }

  addSample(status, seconds) {
    const course = this.courses[status.stage] ??=
        {t: [], rate_hz: [], age_p50_ms: [], age_p99_ms: [], lost: [], bad: [], rss_mb: []};
    if (Math.abs(seconds - course.t.at(-1)) < 0.5) return;  // a second process of the stage
    const kept = course.t.findIndex((t) => t >= seconds);  // the server's clock was set back
    if (kept >= 0) {
      for (const values of Object.values(course)) values.length = kept;
    }
    const sample = {t: seconds, rate_hz: status.rate_hz, age_p50_ms: status.age_p50_ms,
                    age_p99_ms: status.age_p99_ms, lost: lostOf(status), bad: status.bad_messages,
                    rss_mb: status.rss_bytes / 2 ** 20};
    for (const [name, value] of Object.entries(sample)) {
      course[name].push(value);
      if (course[name].length > kMaxSamples) course[name].shift();
    }
  }

  addRow(stage) {
    const row = this.body.insertRow();
    row.dataset.stage = stage;
    const cell = (className, tag) => {
      const td = row.insertCell();
      td.className = className;
      return tag ? td.appendChild(document.createElement(tag)) : td;
    };
    const name = cell('name');
    const dot = name.appendChild(document.createElement('span'));
    name.append(stage);
    const health = name.appendChild(document.createElement('span'));
    health.className = 'health';
    const frames = cell('frames');
    const plots = kColumns.map((column) => {
      const plot = cell(column.name, 'div');
      plot.className = 'plot';
      return {value: plot.appendChild(document.createElement('span')),
              canvas: plot.appendChild(document.createElement('canvas'))};
    });
    return {row, dot, health, frames, plots, complaint: cell('complaint')};
  }

  fillRow(row, status) {
    row.dot.className = `dot ${status.health}`;
    row.health.textContent = status.health === 'good' ? '' : status.health;
    const heard = status.pid !== undefined;
    row.frames.textContent = heard ? status.frames_out : '';
    row.complaint.textContent = row.complaint.title = status.last_error ?? '';
    kColumns.forEach((column, i) => {
      row.plots[i].value.textContent = heard ? column.value(status) : '';
      this.plot(row.plots[i].canvas, column, this.courses[status.stage]);
    });
  }

  plot(canvas, column, course) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => side * devicePixelRatio);
    [canvas.width, canvas.height] = [width, height];
    if (!course || course.t.length < 2 || width < 8) return;
    const end = course.t.at(-1);
    const start = this.whole ? course.t[0] : Math.max(course.t[0], end - kSpan);
    const first = course.t.findIndex((t) => t >= start);
    const lines = column.fields.map((field) => {
      const values = course[field].slice(first);
      return column.steps ? values.map((value, i) => i === 0 ? 0 : Math.max(0, value - values[i - 1])) : values;
    });
    const top = Math.max(column.steps ? 1 : 1e-9, ...lines.flat());
    const context = canvas.getContext('2d');
    lines.forEach((values, line) => {
      context.strokeStyle = column.steps ? kLines[1] : kLines[line];
      context.lineWidth = 1.5 * devicePixelRatio;
      context.beginPath();
      values.forEach((value, i) => {
        const x = (course.t[first + i] - start) / Math.max(1, end - start) * (width - 2) + 1;
        const y = height - 2 - value / top * (height - 5);
        i === 0 ? context.moveTo(x, y) : context.lineTo(x, y);
      });
      context.stroke();
    });
  }
}

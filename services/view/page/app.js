// The page as a whole: follows the graph, or a log, and says what is on show.

import {Cloud} from './cloud.js';
import {Connection} from './connection.js';
import {addControls} from './controls.js';
import {Hover} from './hover.js';
import {Colors, Panes} from './panes.js';
import {Plots} from './plots.js';
import {Target} from './target.js';
import {TimeLine} from './timeline.js';

const byId = (id) => document.getElementById(id);
const nextPicture = () => new Promise((resolve) => requestAnimationFrame(resolve));

class App {
  constructor() {
    this.isLog = false;
    this.playing = true;  // follows the graph, or plays the log
    this.key = 0;         // on show
    this.keys = [0, -1];
    this.frames = 0;      // drawn since the page was opened
    this.times = [];      // of the last pictures, ms
    this.panes = new Panes(byId('panes'), (u, v) => this.hover.at(u, v), () => this.wish());
    this.cloud = new Cloud(this.panes.panes.get('cloud'));
    this.hover = new Hover(byId('pixel'), this.panes, () => this.connection);
    this.target = new Target(this.panes, () => this.connection);
    this.plots = new Plots(byId('stages'));
    this.timeLine = new TimeLine((key) => this.look(key));
    addControls(this);
    this.connection = new Connection({
      open: () => this.opened(),
      closed: () => this.closed(),
      refused: (why) => this.refused(why),
      frame: (head) => this.draw(head),
      text: (message) => this.onText(message),
    });
    setInterval(() => this.showRate(), 500);
  }

  wish() {
    clearTimeout(this.wishTimer);
    this.wishTimer = setTimeout(() => this.connection?.send({type: 'wish', ...this.panes.wish()}), 30);
  }

  opened() {
    document.body.classList.remove('stale');
    this.connection.send({type: 'wish', ...this.panes.wish()});
    this.target.ask();
  }

  closed() {
    this.lose('no answer', 'sprout-view does not answer; it is called again until it does.');
  }

  refused(why) {
    this.lose('refused', `sprout-view refuses this page: ${why}; it is called again until it takes it.`);
  }

  lose(mode, text) {
    document.body.classList.add('stale');
    this.setMode('lost', mode);
    this.say(text, true);
  }

  onText(message) {
    if (message.type === 'hello') this.hello(message);
    else if (message.type === 'status') this.status(message);
    else if (message.type === 'probe') this.hover.show(message);
    else if (message.type === 'measure') this.target.show(message);
    else if (message.type === 'gone') this.newest();
    else if (message.type === 'error') this.say(message.text, false);
  }

  hello(message) {
    // A server that was started again may show another log, or the graph, so nothing is kept.
    const shows = ({mode, file, prefix}) => `${mode} ${file} ${prefix}`;
    if (this.greeting && shows(this.greeting) !== shows(message)) return location.reload();
    this.greeting = message;
    this.isLog = message.mode === 'log';
    this.colors = new Colors(message.colors);
    this.plots.start(message.history, this.isLog);
    document.title = this.isLog ? `${message.file} – Sprout` : `Sprout${message.prefix ? ` ${message.prefix}` : ''}`;
    if (this.isLog) {
      this.playing = false;
      this.timeLine.follow();
      if (!this.start(message)) this.look(this.key);
    } else {
      this.newest();
    }
    this.say('', false);
  }

  // Goes to the frame of --frame once, as soon as its key is known.
  start(message) {
    if (this.started || message.start === undefined) return false;
    this.started = true;
    this.keys = message.keys;
    this.look(message.start);
    return true;
  }

  status(message) {
    this.board = message.board;
    this.statusMessage = message;
    if (this.playing || this.isLog) this.keys = message.keys;
    if (this.isLog) this.start(message);
    this.plots.update(message.board, (message.utime ?? 0) * 1e-6);
    this.timeLine.set(this.keys, this.key, this.playing);
    const none = message.keys[1] < message.keys[0];
    if (none && !this.isLog) {
      this.say(`No frames yet, on ${this.greeting.url}` +
          (this.greeting.prefix ? ` with the prefix ${this.greeting.prefix}` : '') + `. ${message.complaint}`, false);
    } else if (this.isLog && message.read < 1) {
      this.say(`Reading the log: ${(100 * message.read).toFixed(0)} %`, false);
      if (this.frames === 0 && this.wanted === undefined) this.look(0);
    } else {
      this.say(this.isLog ? message.complaint : '', false);
    }
    if (!document.body.classList.contains('stale')) this.showMode();
  }

  say(text, lost) {
    const banner = byId('banner');
    banner.textContent = text;
    banner.hidden = !text;
    banner.classList.toggle('lost', lost);
  }

  setMode(className, text) {
    byId('mode').className = `chip ${className}`;
    byId('mode').textContent = text;
    byId('pause').textContent = this.playing ? 'Pause' : this.isLog ? 'Play' : 'Go on';
  }

  showMode() {
    if (this.isLog) this.setMode(this.playing ? 'live' : 'paused', this.playing ? 'playing' : 'log');
    else this.setMode(this.playing ? 'live' : 'paused', this.playing ? 'live' : 'paused');
  }

  // A frame came. Only when it is drawn the next one is asked for: a slow browser gets fewer.
  async draw(head) {
    try {
      await this.panes.draw(head, this.colors);
      if (this.panes.isShown('cloud')) {
        this.cloud.draw(head.parts.find((part) => part.name === 'cloud'), head.scales, this.colors);
      }
      await nextPicture();
    } finally {
      this.connection.send({type: 'drawn'});
    }
    const before = this.head;
    this.head = head;
    this.key = head.key;
    this.keys = head.keys;
    ++this.frames;
    this.drawn = performance.now();
    this.times.push(this.drawn);
    this.showFacts(head);
    this.timeLine.set(this.keys, this.key, this.playing);
    this.hover.ask();
    if (this.isLog && this.playing) this.playOn(before);
  }

  showFacts(head) {
    byId('seq').textContent = head.seq;
    byId('clock').textContent = new Date(head.utime / 1000).toISOString().substring(11, 23);
    const age = this.isLog || !this.playing ? NaN : Date.now() - head.utime / 1000;
    byId('age').textContent = age >= 0 && age < 1e6 ? age.toFixed(0) : '–';
  }

  showRate() {
    const now = performance.now();
    this.times = this.times.filter((time) => now - time < 3000);
    byId('rate').textContent = this.times.length > 1 ?
        (1000 * (this.times.length - 1) / (this.times.at(-1) - this.times[0])).toFixed(1) : '–';
    // The age of a picture grows while no other follows.
    if (now - this.drawn > 1000) this.showFacts(this.head);
  }

  // Plays at the pace at which the frames of the log were taken.
  playOn(before) {
    if (this.key >= this.keys[1]) return this.stop();
    const pace = before && before.key === this.key - 1 ? (this.head.utime - before.utime) / 1000 : 0;
    const spent = performance.now() - (this.lastStep ?? 0);
    clearTimeout(this.playTimer);
    this.playTimer = setTimeout(() => {
      this.lastStep = performance.now();
      if (this.playing) this.connection.send({type: 'look', key: this.key + 1});
    }, Math.max(0, Math.min(2000, pace) - spent));
  }

  stop() {
    this.playing = false;
    this.showMode();
  }

  toggle() {
    if (this.playing) {
      this.stop();
      this.connection.send({type: 'pause'});
    } else if (this.isLog) {
      this.playing = true;
      this.look(this.key >= this.keys[1] ? 0 : this.key + 1, true);
    } else {
      this.newest();
    }
    this.showMode();
  }

  look(key, playing = false) {
    this.playing = playing;
    const [first, last] = this.keys;
    const target = last < first ? 0 : Math.min(last, Math.max(first, key));
    this.connection.send({type: 'look', key: target});
    this.wanted = target;
    this.showMode();
  }

  step(count) {
    // Steps from the frame that was asked for last: keys repeat faster than frames are drawn.
    const from = this.playing ? this.key : this.wanted ?? this.key;
    this.look(from + count);
  }

  first() { this.look(this.keys[0]); }

  newest() {
    if (this.isLog) return this.look(this.keys[1]);
    this.playing = true;
    this.wanted = undefined;
    this.connection.send({type: 'live'});
    this.showMode();
  }

  toggleUnit() {
    this.panes.setDepth(!this.panes.depth);
    byId('unit').textContent = this.panes.depth ? 'Disparity' : 'Depth';
  }
}

window.sprout = new App();

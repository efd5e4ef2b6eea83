// Pointing: the inputs side by side; what is clicked on one and then on the other becomes a [[feature]] of a job file.
import { byId } from './stage.mjs';
import { carried, colourOf, readData } from './pick_data.mjs';
import { ShapeView, element } from './shape_view.mjs';
import { forShell, jobText, vector } from './job_text.mjs';
import { length, minus } from './surface.mjs';

const OFF = 0.1;  // share of a shape's size by which a match that misses a place is told in colour

class Picker {
  constructor(data) {
    this.data = data;
    this.places = data.features.filter(f => f.kind === 'point').map(f => ({ name: f.name, at: f.positions.map(p => p[0]) }));
    this.chosen = -1;   // index of the place that keys act on
    this.hover = null;  // {view, place, hit} under the pointer
    this.past = [JSON.stringify(this.places)], this.now = 0;
    const act = { picked: (v, hit) => this.pick(v.index, hit.place), hovered: (v, hit) => this.hovered(v, hit), moved: v => this.follow(v),
      markMoved: (mark, hit, done) => this.moveMark(mark, hit, done), markKey: (mark, e) => this.markKey(mark, e),
      markChosen: mark => this.choose(mark.index) };
    this.views = data.shapes.map((_, k) => new ShapeView(data, k, act));
    byId('shapes').replaceChildren(...this.views.map(v => v.node));
    this.startControls();
    this.startTable();
    this.update();
    const kind = data.overlap === null ? 'clay' : 'meeting';
    byId('paint').value = kind;
    for (const view of this.views) view.paint(kind);
  }

  names(k) { return this.data.shapes[k].short; }
  /// The place that is not on all shapes yet; -1: none.
  open() { return this.places.findIndex(p => p.at.includes(null)); }

  /// Places without a name of their own are called by their numbers.
  nameOf(index) { return this.places[index].name || 'place ' + (index + 1); }

  pick(k, place) {
    let index = this.open();
    if (index < 0) index = this.places.push({ name: '', at: this.data.shapes.map(() => null) }) - 1;
    this.places[index].at[k] = place;
    this.chosen = index;
    this.commit();
  }

  choose(index) {
    if (this.chosen === index) return;
    this.chosen = index;
    this.update();
  }

  moveMark(mark, hit, done) {
    if (hit) this.places[mark.index].at[mark.view] = hit.place;
    done ? this.commit() : this.update();
  }

  markKey(mark, event) {
    if (event.key !== 'Delete' && event.key !== 'Backspace') return;
    event.preventDefault();
    this.remove(mark.index);
  }

  remove(index) {
    if (!this.places[index]) return;
    this.places.splice(index, 1);
    if (index < this.chosen) --this.chosen;
    this.chosen = Math.min(this.chosen, this.places.length - 1);
    this.commit();
  }

  /// What was done is kept, to be undone.
  commit() {
    const state = JSON.stringify(this.places);
    if (state !== this.past[this.now]) this.past.splice(++this.now, Infinity, state);
    this.update();
  }

  step(by) {
    if (!this.past[this.now + by]) return;
    this.places = JSON.parse(this.past[this.now += by]);
    this.chosen = Math.min(this.chosen, this.places.length - 1);
    this.update();
  }

  hovered(view, hit) {
    this.hover = hit && { view, place: hit.place, hit };
    this.showMarks();
  }

  /// Shapes turn together where that is wanted.
  follow(view) {
    if (this.turning || !byId('together').checked) return;
    this.turning = true;
    for (const other of this.views) if (other !== view) other.lookAs(view);
    this.turning = false;
  }

  /// Where the match has the like of a place that is on some shapes only; null: not known.
  expected(place, k) {
    const from = place.at.findIndex(p => p);
    return from < 0 ? null : carried(this.data, from, k, place.at[from]);
  }

  /// Limbs that meet have one letter, too, for who does not tell their colours apart.
  letterOf(group) {
    const groups = [...new Set(this.data.shapes.flatMap(s => s.limbs.map(l => l.group)))].filter(g => g >= 0).sort((a, b) => a - b);
    return String.fromCharCode(65 + groups.indexOf(group) % 26);
  }

  marksOf(k) {
    const marks = [];
    const mark = (key, text, colour, place, kind, label, more = {}) => place && marks.push({ key, text, colour, place, kind, label, view: k, ...more });
    if (byId('limbs').checked)
      this.data.shapes[k].limbs.forEach((limb, i) => limb.group >= 0 && mark('limb' + i, this.letterOf(limb.group), colourOf(limb.group),
        limb.line[limb.line.length - 1], 'limb', 'limb ' + this.letterOf(limb.group)));
    this.data.landmarks.forEach((l, i) => mark('landmark' + i, '', colourOf(i), l[k], 'landmark', 'landmark ' + (i + 1)));
    this.data.features.forEach((f, i) => f.kind === 'disk' && mark('disk' + i, '', '#1d2126', f.positions[k][0], 'landmark', f.name));
    this.places.forEach((p, index) => {
      const label = this.nameOf(index) + ' on ' + this.names(k);
      mark('place' + index, String(index + 1), colourOf(index), p.at[k], 'place', label, { index, chosen: index === this.chosen });
      if (!p.at[k] && index === this.open()) mark('expected', '', colourOf(index), this.expected(p, k), 'ghost', 'here the match has it');
    });
    if (this.hover && this.hover.view.index !== k && this.open() < 0)
      mark('hover', '', '#1d2126', carried(this.data, this.hover.view.index, k, this.hover.place, this.hover.hit), 'ghost', 'here the match has it');
    return marks;
  }

  showMarks() { this.views.forEach((view, k) => view.show(this.marksOf(k))); }

  /// By how much the match misses a place, as a share of the shape's size, the worst; null: not known.
  missOf(place) {
    const misses = place.at.map((p, k) => {
      const there = k > 0 && p && place.at[0] ? carried(this.data, 0, k, place.at[0]) : null;
      return there && length(minus(p, there)) / this.data.shapes[k].size;
    }).filter(m => m !== null && m !== false);
    return misses.length ? Math.max(...misses) : null;
  }

  say() {
    const index = this.open(), count = this.places.length;
    if (index < 0) return count ? `${count} ${count > 1 ? 'places' : 'place'}. Click another one, drag a mark, or take the job file.`
      : 'Click a place on one shape.';
    const missing = this.data.shapes.map((_, k) => k).filter(k => !this.places[index].at[k]);
    return `Now click the like of ${this.nameOf(index)} on ${missing.map(k => this.names(k)).join(' and ')}.`;
  }

  update() {
    this.showMarks();
    byId('pickSay').textContent = this.say();
    byId('pickUndo').disabled = this.now === 0;
    byId('pickRedo').disabled = this.now + 1 >= this.past.length;
    byId('pickRemove').disabled = !this.places[this.chosen];
    byId('pickTake').hidden = this.data.overlap === null;
    byId('pickTake').disabled = this.open() < 0;
    byId('jobSaid').textContent = '';
    this.fillTable();
    byId('jobText').textContent = jobText(this.data, this.places.map((p, index) => ({ ...p, name: this.nameOf(index) }))) || '# nothing yet';
    const whole = this.places.some(p => !p.at.includes(null));
    byId('jobSave').classList.toggle('ready', whole);
  }

  startTable() {
    const head = byId('placeTable').createTHead().insertRow();
    for (const text of ['', 'name', ...this.data.shapes.map(s => 'on ' + s.short), ...(this.data.overlap === null ? [] : ['the match misses it by']), ''])
      head.append(element('th', { textContent: text, scope: 'col' }));
    this.body = byId('placeTable').createTBody();
  }

  /// Rows stay while there are as many, so that a name can be typed.
  fillTable() {
    byId('placePart').hidden = !this.places.length;
    while (this.body.rows.length > this.places.length) this.body.deleteRow(-1);
    while (this.body.rows.length < this.places.length) this.body.append(this.rowNode(this.body.rows.length));
    this.places.forEach((place, index) => {
      const row = this.body.rows[index], cells = row.cells, count = this.data.shapes.length;
      row.className = index === this.chosen ? 'chosen' : '';
      const name = cells[1].firstChild;
      if (name !== document.activeElement) name.value = place.name;
      name.placeholder = 'place ' + (index + 1);
      place.at.forEach((p, k) => {
        cells[2 + k].textContent = p ? vector(p, this.data.shapes[k].size * 1e3).slice(1, -1) : 'click it';
        cells[2 + k].className = p ? '' : 'soft';
      });
      if (this.data.overlap === null) return;
      const miss = this.missOf(place);
      cells[2 + count].textContent = miss === null ? '' : (100 * miss).toFixed(miss < 0.01 ? 1 : 0) + ' % of its size';
      cells[2 + count].className = miss > OFF ? 'off' : '';
    });
  }

  rowNode(index) {
    const dot = element('span', { className: 'dot', textContent: index + 1 });
    dot.style.setProperty('--colour', colourOf(index));
    const name = element('input', { type: 'text', maxLength: 60 });
    name.setAttribute('aria-label', 'name of place ' + (index + 1));
    name.oninput = () => { this.places[index].name = name.value, this.update(); };
    name.onchange = () => this.commit();
    const remove = element('button', { type: 'button', textContent: 'remove', onclick: e => { e.stopPropagation(), this.remove(index); } });
    remove.setAttribute('aria-label', 'remove place ' + (index + 1));
    const cell = node => element('td', {}, node ? [node] : []);
    const row = element('tr', {}, [cell(dot), cell(name), ...this.data.shapes.map(() => cell()), ...(this.data.overlap === null ? [] : [cell()]), cell(remove)]);
    row.onclick = () => this.choose(index);
    return row;
  }

  takeExpected() {
    const place = this.places[this.open()];
    if (!place) return;
    this.data.shapes.forEach((_, k) => { place.at[k] = place.at[k] || this.expected(place, k); });
    this.commit();
  }

  startControls() {
    byId('pickUndo').onclick = () => this.step(-1);
    byId('pickRedo').onclick = () => this.step(1);
    byId('pickRemove').onclick = () => this.remove(this.chosen);
    byId('pickTake').onclick = () => this.takeExpected();
    byId('jobCopy').onclick = () => this.copy();
    byId('jobSave').onclick = () => this.save();
    byId('limbs').onchange = () => {
      this.views.forEach(v => { v.limbs.visible = byId('limbs').checked, v.draw(); });
      this.showMarks();
    };
    byId('limbsLabel').hidden = !this.data.shapes.some(s => s.limbs.length);
    for (const option of [...byId('paint').options])
      if (option.value === 'meeting' && this.data.overlap === null || option.value === 'own' && !this.data.shapes.some(s => s.own)) option.remove();
    byId('paint').onchange = () => this.views.forEach(v => v.paint(byId('paint').value));
    document.addEventListener('keydown', e => {
      if (!(e.ctrlKey || e.metaKey) || e.target.type === 'text') return;
      const by = e.key === 'z' && !e.shiftKey ? -1 : e.key === 'y' || e.key === 'Z' || e.key === 'z' ? 1 : 0;
      if (by) e.preventDefault(), this.step(by);
    });
  }

  async copy() {
    const text = byId('jobText').textContent;
    try {
      await navigator.clipboard.writeText(text);
    } catch (error) {
      const area = element('textarea', { value: text });
      document.body.append(area);
      area.select();
      document.execCommand('copy');
      area.remove();
    }
    byId('jobSaid').textContent = 'copied';
  }

  save() {
    const link = element('a', { download: this.data.file, href: URL.createObjectURL(new Blob([byId('jobText').textContent], { type: 'application/toml' })) });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    byId('jobSaid').textContent = 'saved as ' + this.data.file;
  }
}

function facts(data) {
  if (data.overlap === null) return 'Not matched yet.';
  // Of shapes that are equal nothing was measured.
  const text = data.overlap > 0 ? `Matched: they overlap by ${(100 * data.overlap).toFixed(0)} %` : 'Matched';
  if (data.turns.length !== 1) return text + '.';
  const { degrees, margin } = data.turns[0];
  return text + `, turned by ${Math.round(degrees)}\u00b0 against each other` +
    (margin >= 0 ? `; the next best way round fits ${(100 * margin).toFixed(0)} % worse.` : '.');
}

/// Fills the part of the page with the data that stand in it.
export function startPicker() {
  const data = readData();
  byId('pickFacts').textContent = facts(data);
  byId('pickMeaning').hidden = data.overlap === null;
  byId('jobLine').textContent = data.job ? 'slicemorph morph --config ' + forShell(data.file) : '';
  try {
    new Picker(data);
  } catch (error) {
    byId('shapes').textContent = 'this browser shows no WebGL: ' + error.message;
  }
  document.body.dataset.pick = 'ready';
  return data.shapes.map(s => s.short);
}

// The job file of what was pointed at.

/// A text as TOML has it.
export function quoted(text) {
  return '"' + [...text].map(c => c === '"' || c === '\\' ? '\\' + c
    : c < ' ' || c === '\x7f' ? '\\u' + c.charCodeAt(0).toString(16).toUpperCase().padStart(4, '0') : c).join('') + '"';
}

/// A number to a millionth of the shape's size, which is what the mesh's single precision has.
export function coordinate(value, size) {
  const digits = Math.min(Math.max(6 - Math.floor(Math.log10(size)), 0), 20);
  return String(Number(value.toFixed(digits)));
}

export const vector = (place, size) => '[' + place.map(x => coordinate(x, size)).join(', ') + ']';

/// One line of a comment, whatever is in the text: a line's end or another control character is none of TOML's comments.
const comment = text => '# ' + text.replace(/[\x00-\x1f\x7f]/g, ' ');

/// A word as a shell takes it.
export const forShell = word => /^[\w.+-]+$/.test(word) ? word : "'" + word.replace(/'/g, "'\\''") + "'";

/// `places`: {name, at}, at[k] being null where shape k was not pointed at.
export function jobText(data, places) {
  let text = data.job;
  for (const place of places) {
    const missing = data.shapes.filter((_, k) => !place.at[k]).map(s => s.short);
    if (missing.length) {
      text += '\n' + comment(place.name + ': not yet on ' + missing.join(', ')) + '\n';
      continue;
    }
    text += '\n[[feature]]\nname = ' + quoted(place.name) + '\npoint = [' +
      place.at.map((p, k) => vector(p, data.shapes[k].size)).join(', ') + ']\n';
  }
  return text.replace(/^\n/, '');
}

// Reads a .usda file by npm's tinyusdz and prints what it holds: node tinyusdz.mjs FOLDER_OF_TINYUSDZ FILE scene|layer
import fs from 'fs';
import path from 'path';
import {pathToFileURL} from 'url';

const [folder, file, kind] = process.argv.slice(2);
// The package is made for browsers: it looks for a window, and fetches its own code.
process.type = 'renderer';
globalThis.window = globalThis;
globalThis.fetch = async url => new Response(fs.readFileSync(new URL(url)), {headers: {'content-type': 'application/wasm'}});
const silent = {print: () => {}, printErr: () => {}};
const {default: load} = await import(pathToFileURL(path.join(folder, 'tinyusdz.js')));
const tinyusdz = await load(silent);

const bytes = fs.readFileSync(file);
const layer = new tinyusdz.TinyUSDZLoaderNative(), stage = new tinyusdz.TinyUSDZLoaderNative();
if (!layer.loadAsLayerFromBinary(bytes, file)) throw new Error(layer.error());
// Also as a scene, by the schemas.
if (kind === 'scene' && !stage.loadFromBinary(bytes, file)) throw new Error(stage.error());
process.stdout.write(layer.layerToString());

// Bundles the scripts into ../assets, the same bytes on every machine: `cargo xtask report --bundle` runs it.
import { build } from 'esbuild';
import { readFile, writeFile } from 'node:fs/promises';

const assets = process.argv[2] ?? '../assets';
const common = { bundle: true, minify: true, format: 'iife', target: 'es2022', legalComments: 'none', charset: 'utf8' };
for (const name of ['viewer', 'points']) {
  await build({ ...common, entryPoints: [`src/${name}.js`], outfile: `${assets}/${name}.js` });
}
await build({ entryPoints: ['node_modules/uplot/dist/uPlot.min.css'], minify: true, outfile: `${assets}/uplot.css` });

let licences = '';
for (const name of ['three', 'uplot']) {
  const { version } = JSON.parse(await readFile(`node_modules/${name}/package.json`, 'utf8'));
  licences += `${name} ${version}\n\n${(await readFile(`node_modules/${name}/LICENSE`, 'utf8')).trim()}\n\n`;
}
await writeFile(`${assets}/LICENCES.txt`, `${licences.trim()}\n`);

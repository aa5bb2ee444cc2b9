// node live.mjs PAGE < RUN: the module of the live page without the page. RUN is JSON: `settings` before the start and `steps` of 1 ms, each a list
// of indices and values, and `every` how many steps the values are printed, after the time that start and steps took, s.
import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8"), { settings, steps, every } = JSON.parse(readFileSync(0, "utf8"));
const packed = page.split('<script type="application/gzip" id="module">')[1].split("<")[0];
const { instance: { exports: w } } = await WebAssembly.instantiate(gunzipSync(Buffer.from(packed, "base64")), {});
const text = () => new TextDecoder().decode(new Uint8Array(w.memory.buffer, w.text(), w.text_length()));
const call = (name, ...words) => { if (!w[name](...words)) throw new Error(text()); };
const set = (values) => { for (const [index, value] of values) call("set", index, value); };

w.describe();
const count = text().split("<ScalarVariable ").length - 1;
const seconds = () => { const { user, system } = process.cpuUsage(); return 1e-6 * (user + system); };
const begun = seconds();
set(settings);
call("start");
const started = seconds(), found = [];
steps.forEach((inputs, k) => {
  set(inputs);
  call("advance", (k + 1) / 1000);
  if ((k + 1) % every === 0) found.push([...new Float64Array(w.memory.buffer, w.values(1), count)]);
});
console.log(JSON.stringify({ start: started - begun, run: seconds() - started, found }));

// Prints the hashes of a WebAssembly module, in the order of the program's rows.
import { readFileSync } from "node:fs";

const rows = ["f32", "f64"].flatMap((scalar) =>
  ["inverse dynamics, exact", "six sines and cosines", "control tick", "inverse dynamics, regrouped"].map((what) => [scalar, what]));
const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
rows.forEach(([scalar, what], at) => {
  const hash = BigInt.asUintN(64, instance.exports.newtau_hash(at)).toString(16).padStart(16, "0");
  console.log(`row|${scalar}|${what}|${hash}|0`);
});

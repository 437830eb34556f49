// How many pixels of a picture have the blue of an outline: blue.mjs PICTURE
import { readFileSync } from "node:fs";
import { decodePng } from "../e2e/png.mjs";

const { width, height, at } = decodePng(readFileSync(process.argv[2]));
let blue = 0;
for (let y = 0; y < height; ++y)
  for (let x = 0; x < width; ++x) {
    const [r, g, b] = at(x, y);
    blue += b > 140 && r < 80 && g < 130 ? 1 : 0;
  }
console.log(blue);

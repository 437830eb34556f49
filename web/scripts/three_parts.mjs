// Bundles three without what a tooth never needs: 16 % of the largest file that a page with a tooth loads. The sources
// of its shaders lose comments and indentation; those of materials, maps and effects that no source here uses become
// empty, and so do virtual reality and environment maps. The browser tests draw with everything that is left.
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

const kThree = fileURLToPath(new URL("../node_modules/three/src/Three.js", import.meta.url));
// MeshStandardMaterial; MeshBasicMaterial and LineBasicMaterial. A ShaderMaterial brings its own.
const kMaterials = new Set(["meshphysical", "meshbasic"]);
const kUnusedChunk = new RegExp(
  [
    "shadow|lightprobes|envmap|cube_uv|fog|gradientmap|transmission|iridescence|clearcoat|anisotropy|skin|morph|batching",
    "normalmap|bumpmap|displacement|aomap|lightmap|alphamap|specularmap|roughnessmap|metalnessmap|emissivemap|map_particle",
    "lights_(toon|phong|lambert)|logdepth|alphahash",
  ].join("|"),
);
const kStubs = {
  // As much of it as the renderer calls while nobody wears a headset.
  WebXRManager: `export class WebXRManager {
    enabled = false; isPresenting = false; cameraAutoUpdate = false;
    addEventListener() {} removeEventListener() {} setAnimationLoop() {} dispose() {}
    getEnvironmentBlendMode() {}
  }`,
  PMREMGenerator: "export class PMREMGenerator {}",
};

const nameOf = (path) => /([^/\\]+?)(\.glsl)?\.js$/.exec(path)[1];

// Spaces go only beside brackets, commas and semicolons: "a - -b" needs its own. Lines of the preprocessor stay.
function shortShader(text) {
  return text
    .replace(/\/\*[\s\S]*?\*\//g, "")
    .split("\n")
    .map((line) =>
      line
        .replace(/\/\/.*/, "")
        .trim()
        .replace(/\s+/g, " "),
    )
    .filter((line) => line !== "")
    .map((line) => (line.startsWith("#") ? line : line.replace(/ ?([,;(){}]) ?/g, "$1")))
    .map((line) => `${line}\n`)
    .join("");
}

export const threeParts = {
  name: "three parts",
  setup(build) {
    build.onResolve({ filter: /^three$/ }, () => ({ path: kThree, sideEffects: false }));
    build.onLoad({ filter: /ShaderLib[/\\][^/\\]+\.glsl\.js$/ }, ({ path }) =>
      kMaterials.has(nameOf(path)) ? shader(path) : { contents: 'export const vertex = "", fragment = "";' },
    );
    build.onLoad({ filter: /ShaderChunk[/\\][^/\\]+\.glsl\.js$/ }, ({ path }) => shader(path, isUnused));
    build.onLoad({ filter: new RegExp(`(${Object.keys(kStubs).join("|")})\\.js$`) }, ({ path }) => ({
      contents: kStubs[nameOf(path)],
    }));
  },
};

// Some chunks of an effect also hold what every material needs, outside of any #ifdef: those stay.
function isUnused(path, text) {
  let depth = 0;
  const isGuarded = (line) => {
    if (line.startsWith("#if")) ++depth;
    if (line.startsWith("#endif")) --depth;
    return depth > 0 || line.startsWith("#endif");
  };
  return kUnusedChunk.test(nameOf(path)) && text.trim().split("\n").every(isGuarded);
}

function shader(path, leftOut = () => false) {
  const contents = readFileSync(path, "utf8").replace(/`([^`]*)`/g, (_, text) => {
    const short = shortShader(text);
    return `\`${leftOut(path, short) ? "" : short}\``;
  });
  return { contents };
}

// What nobody may ever see on a page. Runs in the browser, on the page as it is drawn: `findings` is sent there as text,
// so it uses nothing from outside.
export function findings({ language, words, typed, least_px }) {
  const kSlack_px = 1.5; // of fractions of pixels
  const kOverlap_px = 3; // line boxes reach beyond their letters
  const [kLines, kLetters] = [4, 5]; // so many lines of so few letters
  const out = new Set();
  const root = document.documentElement;
  const shown = (text) => JSON.stringify(text.trim().replace(/\s+/g, " ").slice(0, 60));
  const named = (element) => {
    const classes = typeof element.className === "string" ? element.className.trim().split(/\s+/).filter(Boolean) : [];
    return [element.localName, ...classes.slice(0, 2)].join(".");
  };
  const placed = (element) => {
    const parent = element.parentElement;
    return parent === null || parent === document.body ? named(element) : `${named(parent)} > ${named(element)}`;
  };
  const note = (what, element, text = "") =>
    out.add(`${what}: ${placed(element)}${text === "" ? "" : ` ${shown(text)}`}`);

  if (root.scrollWidth > root.clientWidth + 1) {
    const wide = [...document.querySelectorAll("body *")].filter((element) => {
      const { right, width } = element.getBoundingClientRect();
      return width > 0 && right > root.clientWidth + 1 && !inScroller(element);
    });
    note("sideways scrolling", wide.at(-1) ?? document.body, `${root.scrollWidth} of ${root.clientWidth} px`);
  }

  function inScroller(element) {
    for (let at = element.parentElement; at !== null && at !== document.body; at = at.parentElement) {
      const { overflowX } = getComputedStyle(at);
      if (overflowX === "auto" || overflowX === "scroll") return true;
    }
    return false;
  }
  // For screen readers alone: a box of one pixel.
  const isHidden = (element) => {
    for (let at = element; at !== null && at !== document.body; at = at.parentElement) {
      const { width, height } = at.getBoundingClientRect();
      const { overflow, clipPath, opacity } = getComputedStyle(at);
      if ((width <= 1 || height <= 1) && (overflow !== "visible" || clipPath !== "none")) return true;
      if (opacity === "0") return true;
    }
    return false;
  };

  // Room that one scrolls into and finds empty.
  const kTail_px = 300;
  const drawn =
    "body :is(h1, h2, h3, p, li, td, th, dt, dd, a, button, input, select, textarea, canvas, svg, img, label)";
  const lowest = Math.max(
    ...[...document.querySelectorAll(drawn)]
      .filter((element) => element.checkVisibility({ visibilityProperty: true }) && !isHidden(element))
      .map((element) => element.getBoundingClientRect().bottom + scrollY),
  );
  const tail_px = root.scrollHeight - Math.max(lowest, least_px);
  if (tail_px > kTail_px) note("empty tail", root, `${Math.round(tail_px)} px`);

  // Every piece of text, its boxes on the screen.
  const pieces = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node !== null; node = walker.nextNode()) {
    const text = node.data.trim();
    const element = node.parentElement;
    if (text === "" || ["SCRIPT", "STYLE", "OPTION", "TITLE", "NOSCRIPT"].includes(element.nodeName)) continue;
    if (!element.checkVisibility({ visibilityProperty: true, contentVisibilityAuto: true }) || isHidden(element))
      continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const boxes = [...range.getClientRects()].filter(({ width, height }) => width > 0.5 && height > 0.5);
    if (boxes.length > 0) pieces.push({ element, text, boxes });
  }

  for (const { element, text, boxes } of pieces) {
    const scrolls = { x: false, y: false };
    for (let at = element; at !== null && at !== root; at = at.parentElement) {
      const { overflowX, overflowY, position } = getComputedStyle(at);
      const box = at.getBoundingClientRect();
      if (["auto", "scroll"].includes(overflowX)) scrolls.x = true;
      if (["auto", "scroll"].includes(overflowY)) scrolls.y = true;
      const cutX = ["hidden", "clip"].includes(overflowX) && !scrolls.x;
      const cutY = ["hidden", "clip"].includes(overflowY) && !scrolls.y;
      const beyond = boxes.some(
        ({ left, right, top, bottom }) =>
          (cutX && (left < box.left - kSlack_px || right > box.right + kSlack_px)) ||
          (cutY && (top < box.top - 2 * kSlack_px || bottom > box.bottom + 2 * kSlack_px)),
      );
      if (beyond && at.localName !== "body") {
        note("cut off", element, text);
        break;
      }
      if (position === "fixed") break;
    }
    if (!scrolls.x && boxes.some(({ left, right }) => left < -kSlack_px || right > root.clientWidth + kSlack_px))
      note("outside the window", element, text);
    // What takes no pointer is not found at a point.
    if (!scrolls.x && !scrolls.y && getComputedStyle(element).pointerEvents !== "none") {
      const box = boxes[0];
      const [x, y] = [(box.left + box.right) / 2, (box.top + box.bottom) / 2];
      const top = x >= 0 && y >= 0 && x < innerWidth && y < innerHeight ? document.elementFromPoint(x, y) : null;
      const isControl = ["input", "select", "textarea"].includes(top?.localName);
      const around = top?.contains(element) || (element.contains(top) && !isControl);
      // A control that is not drawn, such as a switch's, may lie over its own label.
      const related = top === null || around || getComputedStyle(top).opacity === "0";
      if (!related) note(`covered by ${named(top)}`, element, text);
    }
    // A column that is too narrow for its words breaks them.
    const cjk = /[\u3000-\u9fff]/.test(text);
    if (!cjk && boxes.length >= kLines && text.length / boxes.length < kLetters) note("squeezed", element, text);
    if (/\b(undefined|null|NaN|Infinity)\b|\[object /.test(text)) note("no value", element, text);
    if (/^[a-z_]+\.[a-z0-9_.]+$/.test(text) && words.keys.includes(text)) note("a key", element, text);
    const languages = words.languages[text];
    const isName = element.closest("[translate=no], .brand, .sign-in-brand, code") !== null;
    if (languages !== undefined && !isName && !languages.includes(language))
      note(`in ${languages.join(", ")}`, element, text);
  }

  // A sentence or label in English, wherever it comes from: by its small words; between Chinese signs any two words do.
  const kEnglish =
    language === "zh"
      ? /[a-z]{3,}[ ,;:]+[a-z]{3,}/i
      : /(?<![\p{L}\d.-])(?:the|of|is|are|and|with|from|to|for|be|by|on|that|this|has|as|or|its|it|at|until)(?![\p{L}\d-])/u;
  const kCommand = /enamel-(?:server|station|lab)(?: [a-z-]+)*(?: --[a-z-]+)*/g;
  const told = [
    ...pieces.map(({ element, text }) => [element, text]),
    ...[...document.querySelectorAll("option")].map((option) => [option, option.text]),
    ...["aria-label", "title", "placeholder", "alt", "aria-valuetext"].flatMap((name) =>
      [...document.querySelectorAll(`[${name}]`)].map((element) => [element, element.getAttribute(name)]),
    ),
  ];
  for (const [element, text] of language === "en" ? [] : told) {
    if (element.closest("[translate=no], .brand, .sign-in-brand, code") !== null) continue;
    const rest = typed.reduce((left, one) => left.replaceAll(one, "…"), text.replaceAll(kCommand, "…"));
    if (kEnglish.test(rest)) note("in English", element, text);
  }

  // Text over text. Only what is beside each other in height is compared.
  const boxes = pieces.flatMap(({ element, text, boxes: own }) => own.map((box) => ({ element, text, box })));
  boxes.sort((a, b) => a.box.top - b.box.top);
  for (const [i, a] of boxes.entries())
    for (let k = i + 1; k < boxes.length && boxes[k].box.top < a.box.bottom - kOverlap_px; ++k) {
      const b = boxes[k];
      if (a.element === b.element || a.element.contains(b.element) || b.element.contains(a.element)) continue;
      const across = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
      const down = Math.min(a.box.bottom, b.box.bottom) - b.box.top;
      if (across > kOverlap_px && down > kOverlap_px && !inScroller(a.element) && !inScroller(b.element))
        note(`over ${shown(b.text)}`, a.element, a.text);
    }

  // A cell that is not shown. Where a table is cards, all of its head is hidden.
  for (const cell of document.querySelectorAll("td, th")) {
    const head = cell.closest("thead");
    const table = cell.closest("table");
    if (!table?.checkVisibility({ visibilityProperty: true }) || isHidden(table)) continue;
    if (head !== null && (!head.checkVisibility() || isHidden(head))) continue;
    if (!cell.checkVisibility({ visibilityProperty: true })) note("hidden column", cell, cell.textContent || "empty");
  }

  // A control, a heading or a column without a word.
  for (const element of document.querySelectorAll("a, button, h1, h2, h3, h4, th, legend, summary, label, dt")) {
    if (!element.checkVisibility({ visibilityProperty: true }) || isHidden(element)) continue;
    const image = element.querySelector("img[alt], svg[aria-label], [role=img][aria-label], input, select");
    const told = element.textContent.trim() || element.getAttribute("aria-label") || element.title || image;
    const corner = element.localName === "th" && element.closest("tr")?.querySelector("th") === element;
    if (!told && !corner) note("empty", element);
    const { width, height } = element.getBoundingClientRect();
    if (told && (width < 1 || height < 1) && getComputedStyle(element).display !== "contents")
      note("no size", element, element.textContent);
  }
  return [...out];
}

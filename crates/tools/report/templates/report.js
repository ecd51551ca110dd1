"use strict";
// Sorting, filters, pointers, comparison of pictures. A page is complete without any of it.
document.addEventListener("DOMContentLoaded", () => {
  const make = (tag, properties = {}, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };
  const save = (name, text, type) => {
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  // A link into what is folded opens it.
  const reveal = (hash) => {
    const at = document.getElementById(hash.slice(1));
    for (let part = at && at.closest("details"); part; part = part.parentElement.closest("details")) part.open = true;
    return at;
  };
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='#']");
    if (link) reveal(link.hash);
  });
  const wanted = reveal(location.hash);
  if (wanted) wanted.scrollIntoView();

  // A command that the page has already is the number of the element that has it.
  const commands = [...document.querySelectorAll("[data-command]")];
  for (const element of commands) {
    const first = /^@(\d+)$/.exec(element.dataset.command);
    if (first) element.dataset.command = commands[first[1]].dataset.command;
  }

  // What a mark or a cell says, beside it: on hover, on focus, on a tap.
  let tip = null;
  const hide = () => { if (tip) { tip.remove(); tip = null; } };
  const show = (at, text, command) => {
    hide();
    tip = make("div", { className: "tip", role: "status" }, text);
    if (command) {
      const copy = make("button", { type: "button", textContent: "copy" });
      copy.addEventListener("click", () => navigator.clipboard && navigator.clipboard.writeText(command));
      tip.append(make("code", { textContent: command }), copy);
    }
    document.body.append(tip);
    const box = at.getBoundingClientRect();
    const left = Math.min(box.left, document.documentElement.clientWidth - tip.offsetWidth - 8);
    tip.style.left = Math.max(4, left) + scrollX + "px";
    tip.style.top = box.bottom + 6 + scrollY + "px";
  };
  let leaving = 0;
  const says = (element, text) => {
    const open = () => { clearTimeout(leaving); show(element, text, element.dataset.command); };
    element.addEventListener("pointerenter", open);
    element.addEventListener("focusin", open);
    element.addEventListener("click", open);
    element.addEventListener("pointerleave", () => {
      leaving = setTimeout(() => { if (!tip || !tip.matches(":hover")) hide(); }, 300);
    });
    element.addEventListener("focusout", hide);
    element.classList.add("says");
  };

  // What the words of a text mean, a line each: those that the glossary on this page has.
  const meanings = new Map();
  for (const entry of document.querySelectorAll(".glossary div")) {
    const word = entry.querySelector("code").textContent;
    const key = word.toLowerCase().replace(/_/g, " ");
    meanings.set(key, (meanings.get(key) || []).concat(word + ": " + entry.querySelector("dd").textContent));
  }
  const longestFirst = [...meanings.keys()].sort((a, b) => b.length - a.length);
  const keys = longestFirst.map((key) => key.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")).join("|");
  const word = new RegExp("(?<![\\p{L}\\p{N}-])((?:" + keys + ")(?:e?s)?)(?![\\p{L}\\p{N}-])", "giu");
  const meaning = (key) => meanings.get(key) || meanings.get(key.replace(/s$/, "")) || meanings.get(key.replace(/es$/, ""));
  const explained = (text) => {
    const found = meanings.size ? [...text.replace(/_/g, " ").matchAll(word)] : [];
    return [...new Set(found.flatMap(([key]) => meaning(key.toLowerCase())))].join("\n");
  };
  // A cell's own text without its small print.
  const own = (cell) => [...cell.childNodes].filter((n) => !(n.classList && n.classList.contains("detail"))).map((n) => n.textContent).join("").trim();
  for (const spot of document.querySelectorAll(".spot")) {
    const title = spot.querySelector("title");
    spot.setAttribute("aria-label", title.textContent);
    says(spot, title.textContent);
    title.remove();
  }
  for (const cell of document.querySelectorAll("[data-command]:not(.spot)")) {
    cell.tabIndex = 0;
    const what = cell.dataset.command.startsWith("terrafill render") ? "Draw it again:" : "To see more:";
    says(cell, cell.matches("th, .name") ? [explained(own(cell)), what].filter(Boolean).join("\n") : what);
  }
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
  document.addEventListener("pointerdown", (event) => {
    if (tip && !tip.contains(event.target) && !event.target.closest(".says")) hide();
  });

  // Tables: sorted by a heading, filtered by words and status; the address keeps both.
  const units = { B: 1, kB: 1e3, MB: 1e6, GB: 1e9 };
  const number = (text) => {
    const found = text.replace(/\u202f/g, "").match(/^-?[\d.]+(e-?\d+)?/);
    if (!found) return null;
    const unit = text.match(/\b(kB|MB|GB|B)\b/);
    return parseFloat(found[0]) * (unit ? units[unit[1]] : 1);
  };
  const state = new URLSearchParams(location.hash.startsWith("#~") ? location.hash.slice(2) : "");
  const remember = (key, value) => {
    if (value) state.set(key, value); else state.delete(key);
    const text = state.toString();
    history.replaceState(null, "", text ? "#~" + text : location.href.split("#")[0]);
  };
  for (const table of document.querySelectorAll("table")) {
    const body = table.tBodies[0];
    // A remark belongs to the row above it.
    const rows = [];
    for (const row of body.rows) {
      if (row.classList.contains("remark")) rows[rows.length - 1].push(row); else rows.push([row]);
    }
    const headings = [...table.tHead.rows[0].cells];
    // On a phone a row of many figures is a card, in which each says its heading.
    if (headings.length > 4 && !table.className) {
      table.className = "labelled";
      for (const [row] of rows) [...row.cells].forEach((cell, index) => {
        cell.dataset.label = headings[index].textContent.trim();
        if (cell.textContent.length > 40) cell.classList.add("long");
      });
    }
    const csv = make("button", { type: "button", textContent: "CSV" });
    csv.addEventListener("click", () => {
      const cell = (text) => /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
      const lines = rows.map(([row]) => [...row.cells].map((c) => cell(own(c).replace(/\u202f/g, ""))));
      lines.unshift(headings.map((h) => cell(h.textContent.trim())));
      save(table.id + ".csv", lines.map((l) => l.join(",")).join("\n") + "\n", "text/csv");
    });
    const tools = make("div", { className: "tools" }, csv);
    table.parentElement.before(tools);
    if (rows.length < 3 || table.classList.contains("upright")) continue;
    const sort = (index, descending) => {
      const key = ([row]) => { const text = own(row.cells[index]); return [number(text), text]; };
      const order = (a, b) => {
        const [x, s] = key(a), [y, t] = key(b);
        if (x === null && y === null) return descending ? t.localeCompare(s) : s.localeCompare(t);
        if (x === null || y === null) return x === null ? 1 : -1;
        return descending ? y - x : x - y;
      };
      for (const group of [...rows].sort(order)) body.append(...group);
      headings.forEach((h, i) => i === index ? h.setAttribute("aria-sort", descending ? "descending" : "ascending") : h.removeAttribute("aria-sort"));
    };
    headings.forEach((heading, index) => {
      const button = make("button", { type: "button", title: heading.title }, ...heading.childNodes);
      heading.append(button);
      button.addEventListener("click", () => {
        const descending = heading.getAttribute("aria-sort") === "ascending";
        sort(index, descending);
        remember(table.id + ".sort", index + (descending ? "-" : ""));
      });
    });
    const words = make("input", { type: "search", placeholder: "filter rows", ariaLabel: "Filter rows by words" });
    const shown = make("span");
    const filter = () => {
      const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
      let count = 0;
      for (const group of rows) {
        const text = group.map((row) => row.textContent).join(" ").toLowerCase();
        const fits = wanted.every((word) => word.startsWith("-") && word.length > 1 ? !text.includes(word.slice(1)) : text.includes(word));
        count += fits;
        for (const row of group) row.classList.toggle("hidden", !fits);
      }
      shown.textContent = count === rows.length ? rows.length + " rows" : count + " of " + rows.length + " rows";
    };
    words.addEventListener("input", () => { filter(); remember(table.id + ".words", words.value); });
    tools.prepend(words, shown);
    words.value = state.get(table.id + ".words") || "";
    filter();
    const sorted = state.get(table.id + ".sort");
    if (words.value || sorted) reveal("#" + table.id);
    if (sorted) sort(parseInt(sorted, 10), sorted.endsWith("-"));
  }

  // Columns, names of rows, legends and answers say what their words mean.
  const met = new Set();
  for (const named of document.querySelectorAll("thead th, tbody th:not([data-command]), td.name:not([data-command]), .plot text")) {
    const lines = [named.title, explained(own(named))].filter(Boolean).join("\n");
    if (!lines || named.closest(".spot")) continue;
    named.removeAttribute("title");
    const button = named.querySelector("button");
    // The tab key stops at each name once.
    if (button) button.removeAttribute("title"); else named.setAttribute("tabindex", met.has(lines) ? -1 : 0);
    met.add(lines);
    says(named, lines);
  }
  for (const answer of document.querySelectorAll(".lead, .chapter > .names li")) {
    if (answer.children.length) continue;
    // A command is for copying: its words are explained in front of it.
    const text = answer.textContent, at = text.search(/terrafill (?:bench|render) /);
    const [words, command] = at < 0 ? [text, ""] : [text.slice(0, at), text.slice(at)];
    const pieces = meanings.size ? words.split(word) : [words];
    if (pieces.length < 2 && !command) continue;
    answer.replaceChildren(...pieces.map((piece, index) => {
      if (index % 2 === 0) return piece;
      const term = make("span", { className: "term", textContent: piece, tabIndex: 0 });
      says(term, explained(piece));
      return term;
    }), ...(command ? [make("code", { textContent: command })] : []));
  }

  // In a single file plots have no drawings beside them.
  for (const figure of document.querySelectorAll(".plot")) {
    if (figure.querySelector("a[href$='.svg']")) continue;
    const button = make("button", { type: "button", textContent: "SVG" });
    button.addEventListener("click", () => {
      const svg = figure.querySelector("svg").cloneNode(true);
      svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
      save("plot.svg", svg.outerHTML.replace(/var\(--paper\)/g, "#fff").replace(/currentColor/g, "#1b1f24"), "image/svg+xml");
    });
    figure.append(make("div", { className: "tools" }, button));
  }

  // A picture laid over the reference, with an edge to move.
  for (const pictures of document.querySelectorAll(".pictures[data-reference]")) {
    const own = [...pictures.querySelectorAll("figure")].map((f) => [f.querySelector("img"), f.querySelector("li")]).filter(([img, note]) => img && note);
    if (own.length === 0) continue;
    const first = pictures.dataset.reference === "#first";
    const below = make("img", { src: first ? pictures.querySelector("img").src : pictures.dataset.reference, alt: "reference", loading: "lazy" });
    const above = make("img", { alt: "picture", loading: "lazy" });
    const edge = make("input", { type: "range", min: 0, max: 100, value: 50, ariaLabel: "Edge between reference and picture" });
    const which = make("select", { ariaLabel: "Picture to compare" });
    own.forEach(([, note], index) => which.append(make("option", { value: index, textContent: note.textContent.slice(0, 90) })));
    const move = () => { above.style.clipPath = "inset(0 0 0 " + edge.value + "%)"; };
    const choose = () => { above.src = own[which.value][0].src; };
    edge.addEventListener("input", move);
    which.addEventListener("change", choose);
    move();
    const wipe = make("details", { className: "wipe" }, make("summary", { textContent: "Compare with the reference by a sliding edge" }));
    wipe.addEventListener("toggle", () => { if (wipe.open && !above.src) choose(); });
    wipe.append(which, make("div", {}, below, above), make("span", { textContent: "left of the edge: reference; right: picture" }), edge);
    pictures.before(wipe);
  }
});

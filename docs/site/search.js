// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Search without a server: search_index.js is a script, for browsers refuse to fetch data for pages from the disk.
"use strict";
(() => {
  const root = document.body.dataset.root;
  const field = document.getElementById("site-search");
  const list = document.getElementById("site-results");
  const MOST = 30;
  const entries = window.SEARCH_INDEX.map(([title, url, text]) => ({title, url, text, lower: (title + " " + text).toLowerCase()}));

  // Every word must begin a word of the entry; those in the title, or the whole phrase, count more.
  function score(entry, words) {
    const title = entry.title.toLowerCase();
    let sum = 0;
    for (const word of words) {
      const start = new RegExp("(^|[^a-z0-9])" + word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
      if (start.test(title))
        sum += 10 + (title === word ? 20 : 0) + (title.endsWith(word) ? 5 : 0);
      else if (start.test(entry.lower))
        sum += 1;
      else
        return 0;
    }
    return sum + (entry.lower.includes(words.join(" ")) ? 5 : 0);
  }

  function excerpt(entry, words) {
    const lower = entry.text.toLowerCase();
    const at = Math.max(0, ...words.map((word) => lower.indexOf(word)));
    const start = at > 60 ? entry.text.indexOf(" ", at - 60) + 1 : 0;
    const shown = entry.text.slice(start, start + 160);
    const cut = shown.length < 160 ? shown : shown.slice(0, Math.max(shown.lastIndexOf(" "), 120)) + " ...";
    return (start > 0 ? "... " : "") + cut;
  }

  function find(text) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    if (words.length === 0)
      return [];
    return entries.map((entry, order) => ({entry, order, score: score(entry, words)}))
      .filter((hit) => hit.score > 0)
      .sort((a, b) => b.score - a.score || a.order - b.order)
      .slice(0, MOST)
      .map((hit) => ({title: hit.entry.title, url: hit.entry.url, text: excerpt(hit.entry, words)}));
  }
  function show() {
    const hits = find(field.value);
    list.replaceChildren(...hits.map((hit) => {
      const item = document.createElement("li");
      const link = item.appendChild(document.createElement("a"));
      link.href = root + hit.url;
      link.textContent = hit.title;
      link.appendChild(document.createElement("small")).textContent = hit.text;
      return item;
    }));
    if (hits.length === 0 && field.value.trim())
      list.appendChild(document.createElement("li")).textContent = "Nothing found";
    list.hidden = !field.value.trim();
  }

  field.addEventListener("input", show);
  document.addEventListener("keydown", (event) => {
    const links = [...list.querySelectorAll("a")];
    const at = links.indexOf(document.activeElement);
    if (event.key === "/" && document.activeElement !== field) {
      field.focus();
      event.preventDefault();
    } else if (event.key === "Escape") {
      field.value = "";
      show();
    } else if ((event.key === "ArrowDown" || event.key === "ArrowUp") && !list.hidden) {
      const next = at + (event.key === "ArrowDown" ? 1 : -1);
      (links[next] || field).focus();
      event.preventDefault();
    } else if (event.key === "Enter" && document.activeElement === field && links.length > 0) {
      links[0].click();
    }
  });
  // A link of the list to the page that is shown already closes the list.
  list.addEventListener("click", () => { list.hidden = true; });

  // index.html?q=words shows what is found.
  const asked = new URLSearchParams(location.search).get("q");
  if (asked) {
    field.value = asked;
    show();
  }
})();

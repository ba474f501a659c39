"use strict";

// Every fault on the page is counted on the document element, where a test (and a curious reader) finds it.
function countFault() {
  const root = document.documentElement;
  root.dataset.errors = String(Number(root.dataset.errors) + 1);
}
window.addEventListener("error", countFault);
window.addEventListener("unhandledrejection", countFault);
document.addEventListener("securitypolicyviolation", countFault);

mod drive;
mod drives;
mod groups;
mod motions;
mod presents;
mod random;
mod sizes;
mod steps;
